#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace weft::app {

/// An option or an argument as completion scripts and the manual page show it.
struct CommandOption {
  std::vector<std::string> words;    ///< "-o", "--output"; empty: an argument, called by its name
  std::string argument;              ///< name of an argument in its place
  std::string value;                 ///< type of the value, such as FILE; empty: takes none
  std::vector<std::string> choices;  ///< all values that are allowed; empty: any
  std::string description;
  std::string fallback;  ///< default value; empty: none
  bool required = false;
};

struct Command {
  std::string name;
  std::string description;
  std::vector<CommandOption> options;
};

/// The program's own options, under the name "weft", and its subcommands, without the hidden ones.
std::vector<Command> command_list(const CLI::App& app);

}  // namespace weft::app
