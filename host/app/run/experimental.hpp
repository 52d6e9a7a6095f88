#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `--experimental PATH=VALUE`, which may be repeated.
/// @param values must outlive the parsing
void add_experimental(CLI::App& subcommand, std::vector<std::string>& values);

/// The same values as words of a command of this program.
std::vector<std::string> experimental_words(const std::vector<std::string>& values);

/// Values of either kind as words of a command of this program: `--experimental` before those that
/// are no keys of scenes, `--set` before the others.
std::vector<std::string> setting_words(const std::vector<std::string>& values);

}  // namespace weft::app
