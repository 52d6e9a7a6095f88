#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds the hidden subcommand `weft manual bash|zsh|fish|man`, which the build calls: prints a
/// completion script or the manual page.
/// @param app       the program, with all of its subcommands; must outlive the parsing
/// @param exit_code must outlive the parsing; set to 0 when the subcommand has run
void add_manual_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
