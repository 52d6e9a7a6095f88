#pragma once

#include <filesystem>

namespace weft {

/// A file descriptor that closes itself.
class FileDescriptor {
 public:
  explicit FileDescriptor(int number = -1) noexcept : number_(number) {}
  FileDescriptor(FileDescriptor&& other) noexcept : number_(other.number_) { other.number_ = -1; }
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor();
  int number() const noexcept { return number_; }

 private:
  int number_;
};

/// Opens a regular file. A pipe or a device is refused and never waited for.
/// @param flags of open(2)
/// @param what  for the message: "read", "open for writing"
/// @throws SceneError naming the file and the reason
FileDescriptor open_regular_file(const std::filesystem::path& path, int flags, const char* what);

}  // namespace weft
