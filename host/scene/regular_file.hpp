#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace weft {

/// An open regular file. A pipe, a device or a directory is refused, and never waited for.
class RegularFile {
 public:
  /// @throws SceneError naming the file and the reason if it is missing, no regular file, or cannot
  ///         be read
  explicit RegularFile(std::filesystem::path path);
  RegularFile(const RegularFile&) = delete;
  RegularFile& operator=(const RegularFile&) = delete;
  ~RegularFile();

  std::uintmax_t size() const { return size_; }  ///< [bytes] when it was opened

  /// What is left to read.
  /// @throws SceneError if it cannot be read
  std::string read_all();

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::uintmax_t size_ = 0;
};

/// The bytes of a regular file; empty if there is none, or if it cannot be read.
std::string text_if_regular(const std::filesystem::path& path);

}  // namespace weft
