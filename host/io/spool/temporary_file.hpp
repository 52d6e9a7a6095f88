#pragma once

#include <filesystem>
#include <system_error>

namespace weft::io {

/// Removes a file at the end, unless it got its name by then.
struct TemporaryFile {
  std::filesystem::path path;
  ~TemporaryFile() {
    std::error_code error;
    std::filesystem::remove(path, error);
  }
};

}  // namespace weft::io
