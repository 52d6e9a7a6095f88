#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft view DIR`: one page that plays the frames of a run.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set when the subcommand runs: 0 done, 2 some input is
/// bad
void add_view_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
