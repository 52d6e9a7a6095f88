#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace weft::app {

/// Adds `--allow-path DIR`, which may be repeated.
/// @param folders must outlive the parsing
void add_allow_path(CLI::App& subcommand, std::vector<std::string>& folders);

/// The same folders as words of a command of this program.
std::vector<std::string> allow_path_words(const std::vector<std::string>& folders);

}  // namespace weft::app
