#include "host/base/file_descriptor.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>
#include <utility>

#include "host/base/file_operations.hpp"
#include "weft/error.hpp"

namespace weft {

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

FileDescriptor::~FileDescriptor() {
  if (number_ >= 0) ::close(number_);
}

FileDescriptor open_regular_file(const std::filesystem::path& path, int flags, const char* what) {
  FileDescriptor file(::open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0666));
  struct stat status = {};
  if (file.number() < 0 || ::fstat(file.number(), &status) != 0) fail_on(path, what);
  if (!S_ISREG(status.st_mode))
    throw SceneError(path.string() + ": cannot " + what + ": not a regular file");
  return file;
}

}  // namespace weft
