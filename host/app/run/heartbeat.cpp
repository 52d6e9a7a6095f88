#include "host/app/run/heartbeat.hpp"

#include <system_error>
#include <utility>

namespace weft::app {

Heartbeat::Heartbeat(Progress& progress, std::function<StepProgress()> ask,
                     std::chrono::milliseconds interval)
    : progress_(progress), ask_(std::move(ask)), interval_(interval) {
  try {
    thread_ = std::jthread([this](const std::stop_token& stop) { look(stop); });
  } catch (const std::system_error&) {
    // The system has no thread left. The run matters more than its heartbeat.
  }
}

void Heartbeat::set_on(bool on) {
  const std::lock_guard lock(mutex_);
  on_ = on;
}

void Heartbeat::look(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    ended_.wait_for(lock, stop, interval_, [] { return false; });
    if (on_) progress_.during_step(ask_());
  }
}

}  // namespace weft::app
