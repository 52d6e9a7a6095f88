#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft plan SCENE`.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set when the subcommand has run. What that throws
/// comes out
///                  of the parsing.
void add_plan_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
