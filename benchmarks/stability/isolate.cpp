#include "benchmarks/stability/isolate.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

namespace weft::stability {
namespace {

using Clock = std::chrono::steady_clock;

std::filesystem::path folder_of(int process) {
  return std::filesystem::temp_directory_path() / fmt::format("weft_stability_{}", process);
}

/// First the outcome's letter, then why.
std::string encoded(const Verdict& verdict) {
  return describe(verdict.outcome)[0] + verdict.detail;
}

void write_all(int descriptor, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(descriptor, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace

std::filesystem::path scratch_folder() {
  auto folder = folder_of(::getpid());
  std::filesystem::create_directories(folder);
  return folder;
}

Child::Child(const Case& c, Setup setup, double limit)
    : case_(c), setup_(std::move(setup)), limit_(limit), start_(Clock::now()) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  std::fflush(nullptr);  // or both processes would write what is not yet written
  process_ = ::fork();
  if (process_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (process_ == 0) {
    ::close(ends[0]);
    write_all(ends[1], encoded(judge(case_, setup_)));
    ::_exit(0);
  }
  ::close(ends[1]);
  descriptor_ = ends[0];
}

Child::~Child() {
  if (process_ > 0) ::kill(process_, SIGKILL);
  reap();
}

/// Waits for the process, whose end is near.
void Child::reap() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (process_ > 0) {
    ::waitpid(process_, &status_, 0);
    std::error_code error;  // what it left is worth no failure
    std::filesystem::remove_all(folder_of(process_), error);
  }
  process_ = -1;
}

bool Child::poll() {
  if (descriptor_ < 0) return true;
  seconds_ = std::chrono::duration<double>(Clock::now() - start_).count();
  pollfd waiting{descriptor_, POLLIN, 0};
  if (::poll(&waiting, 1, 0) > 0) {
    char buffer[4096];
    const ssize_t n = ::read(descriptor_, buffer, sizeof buffer);
    if (n > 0) {
      text_.append(buffer, static_cast<std::size_t>(n));
      return false;
    }
    reap();
    return true;
  }
  if (seconds_ < limit_) return false;
  timed_out_ = true;
  ::kill(process_, SIGKILL);
  reap();
  return true;
}

Verdict Child::verdict() const {
  if (timed_out_) return {Outcome::failed, fmt::format("not done after {:g} s", limit_)};
  if (WIFSIGNALED(status_))
    return {Outcome::failed, fmt::format("crashed: signal {}", WTERMSIG(status_))};
  for (const Outcome outcome : {Outcome::passed, Outcome::refused, Outcome::failed})
    if (!text_.empty() && text_[0] == describe(outcome)[0]) return {outcome, text_.substr(1)};
  return {Outcome::failed,
          fmt::format("ended without a verdict, exit code {}", WEXITSTATUS(status_))};
}

Verdict run_apart(const Case& c, const Setup& setup, double limit) {
  Child child(c, setup, limit);
  while (!child.poll()) {
    pollfd waiting{child.descriptor(), POLLIN, 0};
    ::poll(&waiting, 1, 100);
  }
  return child.verdict();
}

}  // namespace weft::stability
