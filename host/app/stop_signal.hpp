#pragma once

namespace weft::app {

/// From now on a first SIGINT or SIGTERM asks the run to stop after its step; a second one kills
/// it.
void listen_for_signals();

/// Whether one has come since.
bool stop_requested();

}  // namespace weft::app
