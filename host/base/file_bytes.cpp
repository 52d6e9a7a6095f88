#include "host/base/file_bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "host/base/file_descriptor.hpp"
#include "host/base/file_operations.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

std::uint64_t memory_bytes() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGE_SIZE));
}

}  // namespace

std::string read_file_bytes(const std::filesystem::path& path) {
  const FileDescriptor file = open_regular_file(path, O_RDONLY, "read");
  struct stat status = {};
  if (::fstat(file.number(), &status) != 0) fail_on(path, "read");
  const auto size = static_cast<std::uint64_t>(status.st_size);
  // Such a file may be sparse and take no room on the disk.
  if (size > memory_bytes())
    throw SceneError(path.string() + ": cannot read: " + std::to_string(size) +
                     " bytes, more than the memory of this machine");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::read(file.number(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_on(path, "read");
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  bytes.resize(done);
  return bytes;
}

std::string bytes_if_readable(const std::filesystem::path& path) {
  try {
    return read_file_bytes(path);
  } catch (const SceneError&) {
    return {};
  }
}

std::size_t read_at(const std::filesystem::path& path, int file, std::uint64_t offset, void* to,
                    std::size_t size) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t n = ::pread(file, static_cast<char*>(to) + done, size - done,
                              static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_on(path, "read");
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

}  // namespace weft
