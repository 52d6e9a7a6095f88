#pragma once

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `weft plan SCENE`.
/// @param app       program to add the verb to
/// @param exit_code must outlive the parsing; set when the verb has run. What that throws comes out
///                  of the parsing.
void add_plan_verb(CLI::App& app, int& exit_code);

}  // namespace weft::app
