#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft chart SCENE...`.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set to 0 when the subcommand has run. What that
/// throws comes
///                  out of the parsing.
void add_chart_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
