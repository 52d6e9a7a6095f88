#include "host/app/process/stop_signal.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <time.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>

namespace weft::app {
namespace {

std::atomic<bool> requested{false};
std::atomic<double> limit_reached{0};  ///< [s] of a TimeLimit that asked first; 0: none did
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler must not wait for a lock");

/// Signals within this time of the first are the same wish: `timeout` sends one to the program and
/// one to its group. [ms]
constexpr std::int64_t echo = 1000;
std::atomic<std::int64_t> first_signal{0};  ///< [ms] 0: none yet
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

/// [ms] Never 0.
std::int64_t now() {
  timespec time = {};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return 1 + std::int64_t{1000} * time.tv_sec + time.tv_nsec / 1'000'000;
}

extern "C" void take_signal(int signal) {
  requested = true;
  std::int64_t first = 0;
  if (first_signal.compare_exchange_strong(first, now())) return;
  // Whoever reads the output is gone: every further line would say so again.
  if (signal == SIGPIPE || now() - first <= echo) return;
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

void listen_for_signals() {
  requested = false;
  first_signal = 0;
  limit_reached = 0;
  struct sigaction action = {};
  action.sa_handler = take_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    struct sigaction before = {};
    // What whoever started this program ignores stays ignored, as with nohup.
    if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
    ::sigaction(signal, &action, nullptr);
  }
}

bool stop_requested() {
  return requested;
}

void request_stop() {
  requested = true;
}

std::string stop_reason() {
  const double limit = limit_reached;
  return limit > 0 ? fmt::format("stopped by the time limit of {:.6g} s", limit)
                   : std::string("stopped by a signal");
}

TimeLimit::TimeLimit(double seconds) {
  if (!(seconds > 0)) return;
  waits_ = std::jthread([seconds](const std::stop_token& ended) {
    std::mutex mutex;
    std::condition_variable_any wake;
    std::unique_lock lock(mutex);
    wake.wait_for(lock, ended, std::chrono::duration<double>(seconds), [] { return false; });
    if (ended.stop_requested() || requested) return;
    limit_reached = seconds;
    requested = true;
  });
}

DeviceSet stoppable_devices(std::string_view text) {
  DeviceSet devices = parse_devices(text);
  devices.stop_on(&requested);
  return devices;
}

}  // namespace weft::app
