#include "host/io/mesh/child_trial.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <exception>
#include <fstream>
#include <string_view>
#include <system_error>

#include "host/base/file_descriptor.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// What a file of a few bytes may take. Several times what the largest files of others that it
/// names need.
constexpr rlim_t seconds_base = 5;
constexpr rlim_t memory_base = rlim_t{4} << 30;  ///< [bytes] beyond what the parent has
/// A byte of text becomes up to some hundred bytes of tree; the slowest formats take less than a
/// second for 4 MiB.
constexpr rlim_t memory_per_byte = 400;
constexpr rlim_t bytes_per_second = rlim_t{1} << 20;
/// Times the bound on the processor's time: other programs may need the processor too.
constexpr rlim_t waiting = 10;
constexpr std::size_t message_max = 4000;  ///< fits into a pipe that nobody reads yet

enum Exit { read_well = 0, refused = 1 };

/// [bytes] of address space that this process has; 0 if the system does not say
rlim_t address_space() {
  std::ifstream status("/proc/self/statm");
  rlim_t pages = 0;
  return status >> pages ? pages * static_cast<rlim_t>(::sysconf(_SC_PAGE_SIZE)) : 0;
}

struct Bounds {
  rlim_t seconds;  ///< of the processor
  rlim_t memory;   ///< [bytes] of address space; 0: any
};

Bounds bounds_of(std::uintmax_t bytes) {
  const rlim_t before = address_space();
  return {seconds_base + bytes / bytes_per_second,
          before == 0 ? 0 : before + memory_base + memory_per_byte * bytes};
}

void lower(decltype(RLIMIT_AS) resource, rlim_t bound) {
  rlimit limit = {};
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(limit.rlim_cur, bound);
  ::setrlimit(resource, &limit);
}

/// The child never returns, and runs nothing of the parent's at its end.
[[noreturn]] void be_child(int answer, const Bounds& bounds, const std::function<void()>& read) {
  for (const int number :
       {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGTERM, SIGINT, SIGHUP})
    ::signal(number, SIG_DFL);
  lower(RLIMIT_CORE, 0);
  lower(RLIMIT_CPU, bounds.seconds);
#ifndef __SANITIZE_ADDRESS__  // which maps far more than it takes
  if (bounds.memory > 0) lower(RLIMIT_AS, bounds.memory);
#endif
  // A library that dies may want to say so.
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nowhere >= 0) {
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
  }
  std::string_view message;
  try {
    read();
    ::_exit(read_well);
  } catch (const std::exception& error) {
    message = std::string_view(error.what()).substr(0, message_max);
    if (::write(answer, message.data(), message.size()) < 0) ::_exit(read_well + 2);
  } catch (...) {
  }
  ::_exit(refused);
}

/// Waits until the child closes its end.
/// @return whether it did in time
bool ended_in_time(int answer, std::chrono::seconds time, std::string& message) {
  const auto until = std::chrono::steady_clock::now() + time;
  char buffer[message_max];
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        until - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd wanted{answer, POLLIN, 0};
    if (::poll(&wanted, 1, static_cast<int>(left.count())) <= 0) continue;
    const ssize_t n = ::read(answer, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return true;
    message.append(buffer, static_cast<std::size_t>(n));
  }
}

}  // namespace

void try_in_child(const std::filesystem::path& path, const std::string& what,
                  const std::function<void()>& read) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  const Bounds bounds = bounds_of(error ? 0 : bytes);
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) return;
  const FileDescriptor answer(ends[0]);
  const pid_t child = ::fork();
  if (child == 0) be_child(ends[1], bounds, read);
  ::close(ends[1]);
  if (child < 0) return;
  std::string message;
  const std::chrono::seconds time{static_cast<std::int64_t>(waiting * bounds.seconds)};
  const bool in_time = ended_in_time(answer.number(), time, message);
  if (!in_time) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return;  // somebody else has waited for it
  const std::string cannot = path.string() + ": cannot read as " + what + ": ";
  if (!in_time || (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU))
    throw SceneError(cannot + "it takes more than " + std::to_string(bounds.seconds) + " s");
  if (WIFSIGNALED(status))
    throw SceneError(cannot + "the file is damaged, and its reader fails with signal " +
                     std::to_string(WTERMSIG(status)));
  if (WEXITSTATUS(status) != read_well)
    throw SceneError(message.empty() ? cannot + "no reason given" : message);
}

}  // namespace weft::io
