#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "host/base/scratch_folder.hpp"

namespace weft::io {

/// Root of the sources, where scenes/ and tests/ are.
inline std::filesystem::path repository_root() {
  return WEFT_SOURCE_DIR;
}

/// A test with a directory of its own, removed at its end.
class DirectoryTest : public testing::Test {
 protected:
  std::filesystem::path put(const std::string& name, std::string_view bytes) const {
    const std::filesystem::path path = directory_ / name;
    std::ofstream(path, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
  }

  const ScratchFolder folder_;
  const std::filesystem::path directory_ = folder_.path();
};

}  // namespace weft::io
