#include "host/base/file_descriptor.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

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
  const auto fail = [&](const std::string& reason) {
    throw SceneError(path.string() + ": cannot " + what + ": " + reason);
  };
  FileDescriptor file(::open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0666));
  struct stat status = {};
  if (file.number() < 0 || ::fstat(file.number(), &status) != 0)
    fail(std::generic_category().message(errno));
  if (!S_ISREG(status.st_mode)) fail("not a regular file");
  return file;
}

}  // namespace weft
