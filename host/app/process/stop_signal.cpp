#include "host/app/process/stop_signal.hpp"

#include <signal.h>

#include <atomic>

namespace weft::app {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler must not wait for a lock");

extern "C" void take_signal(int signal) {
  // Whoever reads the output is gone: every further line would say so again.
  if (requested.exchange(true) && signal != SIGPIPE) {
    ::signal(signal, SIG_DFL);
    ::raise(signal);
  }
}

}  // namespace

void listen_for_signals() {
  requested = false;
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

DeviceSet stoppable_devices(std::string_view text) {
  DeviceSet devices = parse_devices(text);
  devices.stop_on(&requested);
  return devices;
}

}  // namespace weft::app
