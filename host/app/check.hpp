#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft check DIR|MESH...`: checks frames with weft::lab::validate and prints what is wrong.
/// A directory stands for its frames: frames/cloth_NNNNN.{obj,ply}, each against the obstacle mesh
/// of the same number if the directory has any, point caches, and animated USD. Cloth that
/// intersects an obstacle is checked against displaced/displaced_NNNNN.obj too, if that is there:
/// a frame that is clean against it counts as clean, with a warning.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set when the subcommand runs: 0 nothing found, 1
/// something
///                  found, 2 some input could not be read (whatever was found in the rest)
void add_check_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
