#pragma once

#include <string>
#include <string_view>
#include <thread>

#include "weft/devices.hpp"

namespace weft::app {

/// From now on a first SIGINT, SIGTERM, SIGHUP or SIGPIPE asks the run to stop at its next safe
/// point; one of the first three that comes more than a second later ends the program at once.
void listen_for_signals();

/// Whether one has come since.
bool stop_requested();

/// Asks for it without a signal.
void request_stop();

/// Asks for it once a time has passed, unless it is destroyed before.
class TimeLimit {
 public:
  /// @param seconds of wall time from now on; 0: no limit
  explicit TimeLimit(double seconds);
  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;

 private:
  std::jthread waits_;
};

/// What asked for it, for messages: "stopped by a signal", or by what request_stop() was given.
std::string stop_reason();

/// parse_devices() of devices that stop when stop_requested() becomes true.
DeviceSet stoppable_devices(std::string_view text);

}  // namespace weft::app
