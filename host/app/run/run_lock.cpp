#include "host/app/run/run_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>

#include "host/base/file_operations.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

/// What the holder of the lock has written there: its process number.
std::string holder(int descriptor) {
  char text[16] = {};
  const ssize_t got = ::pread(descriptor, text, sizeof text - 1, 0);
  std::string number(text, got > 0 ? static_cast<std::size_t>(got) : 0);
  number.erase(
      std::find_if(number.begin(), number.end(), [](char c) { return c < '0' || c > '9'; }),
      number.end());
  return number;
}

}  // namespace

RunLock::RunLock(const std::filesystem::path& directory) {
  const std::filesystem::path file = directory / file_name;
  // A link or a pipe of that name is nothing that a run has made.
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
  if (descriptor_ < 0) fail_on(file, "lock");
  struct stat status = {};
  int code = 0;
  if (::fstat(descriptor_, &status) != 0)
    code = errno;
  else if (!S_ISREG(status.st_mode))
    code = EINVAL;
  else if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0)
    code = errno;
  if (code == 0) {
    const std::string number = std::to_string(::getpid()) + "\n";
    // Only for the message of whoever comes second: a full disk is no reason to stop here.
    [[maybe_unused]] const bool written =
        ::ftruncate(descriptor_, 0) == 0 &&
        ::pwrite(descriptor_, number.data(), number.size(), 0) >= 0;
    return;
  }
  const std::string other = holder(descriptor_);
  ::close(descriptor_);
  if (code != EWOULDBLOCK) fail_on(file, "lock", code);
  throw SceneError(directory.string(), "-o",
                   "a directory that another run is writing to" +
                       (other.empty() ? std::string() : ", process " + other),
                   "another directory, or this one once that run has ended");
}

RunLock::~RunLock() {
  ::close(descriptor_);
}

}  // namespace weft::app
