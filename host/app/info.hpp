#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft info`: version, build and devices; with --fabrics what materials may name.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set to 0 when the subcommand has run
void add_info_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
