#include "host/scene/regular_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "weft/error.hpp"

namespace weft {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw SceneError(path.string() + ": cannot read: " + reason);
}

std::string system_reason(int code) {
  return std::generic_category().message(code);
}

}  // namespace

/// O_NONBLOCK: to open a pipe would otherwise wait for whoever writes to it.
RegularFile::RegularFile(std::filesystem::path path)
    : path_(std::move(path)),
      descriptor_(::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {
  if (descriptor_ < 0) fail(path_, errno == ENXIO ? "not a regular file" : system_reason(errno));
  struct stat status = {};
  const bool known = ::fstat(descriptor_, &status) == 0;
  if (known && S_ISREG(status.st_mode)) {
    size_ = static_cast<std::uintmax_t>(status.st_size);
    return;
  }
  const std::string reason = known ? "not a regular file" : system_reason(errno);
  ::close(descriptor_);
  fail(path_, reason);
}

RegularFile::~RegularFile() {
  ::close(descriptor_);
}

std::string RegularFile::read_all() {
  std::string bytes;
  // One byte more than the size, so that the end is seen without another round.
  std::size_t wanted = static_cast<std::size_t>(size_) + 1;
  while (true) {
    const std::size_t before = bytes.size();
    bytes.resize(before + wanted);
    const ssize_t got = ::read(descriptor_, bytes.data() + before, wanted);
    const int code = errno;
    bytes.resize(before + (got > 0 ? static_cast<std::size_t>(got) : 0));
    if (got == 0) return bytes;
    if (got < 0 && code != EINTR) fail(path_, system_reason(code));
    wanted = std::size_t{1} << 16;
    if (bytes.size() < size_) wanted = static_cast<std::size_t>(size_) - bytes.size() + 1;
  }
}

std::string text_if_regular(const std::filesystem::path& path) {
  try {
    return RegularFile(path).read_all();
  } catch (const SceneError&) {
    return {};
  }
}

}  // namespace weft
