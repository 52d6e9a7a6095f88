#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft render DIR`: pictures of all frames of a run, and a film of them if it is asked for.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set when the subcommand runs: 0 done, 2 some input is
/// bad
void add_render_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
