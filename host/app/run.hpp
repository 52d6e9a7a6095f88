#pragma once

#include "host/app/run/run_request.hpp"

namespace CLI {
class App;
}

namespace weft::app {

/// Simulates a scene and writes its directory.
/// @return 0 done, 4 the simulation failed, 130 stopped by a signal or a time limit; for the last
/// two a checkpoint
///         and the report were written
/// @throws SceneError for bad input, a directory that another run uses or has left its files in,
///         or a file that cannot be written
/// @throws DeviceError if a device is missing or fails
int run_scene(const RunRequest& request);

/// Adds `weft run SCENE`.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set when the subcommand runs, see run_scene(). What
/// that
///                  throws comes out of the parsing.
void add_run_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
