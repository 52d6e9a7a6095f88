#pragma once

#include <filesystem>
#include <system_error>
#include <utility>

namespace weft {

/// A file, if it is there, that goes when its user does.
struct PassingFile {
  explicit PassingFile(std::filesystem::path where) : path(std::move(where)) {}
  PassingFile(const PassingFile&) = delete;
  PassingFile& operator=(const PassingFile&) = delete;
  ~PassingFile() {
    std::error_code error;
    std::filesystem::remove(path, error);
  }

  const std::filesystem::path path;
};

}  // namespace weft
