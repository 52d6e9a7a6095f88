#pragma once

#include <string_view>

#include "weft/devices.hpp"

namespace weft::app {

/// From now on a first SIGINT, SIGTERM, SIGHUP or SIGPIPE asks the run to stop at its next safe
/// point; a second one of the first three ends the program at once.
void listen_for_signals();

/// Whether one has come since.
bool stop_requested();

/// Asks for it without a signal.
void request_stop();

/// parse_devices() of devices that stop when stop_requested() becomes true.
DeviceSet stoppable_devices(std::string_view text);

}  // namespace weft::app
