#pragma once

#include <filesystem>
#include <system_error>
#include <utility>

namespace weft {

/// A file, if it is there, that goes when its user does, unless it got its name by then.
struct TemporaryFile {
  explicit TemporaryFile(std::filesystem::path where) : path(std::move(where)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code error;
    std::filesystem::remove(path, error);
  }

  const std::filesystem::path path;
};

}  // namespace weft
