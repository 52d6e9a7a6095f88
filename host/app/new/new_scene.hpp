#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft new CLOTH [BODY]`: writes a scene for mesh files, which it looks at.
/// @param app       program to add the subcommand to
/// @param exit_code must outlive the parsing; set to 0 when the subcommand has run
void add_new_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
