#pragma once

#include <string>
#include <vector>

#include "host/app/manual/command_list.hpp"

namespace weft::app {

/// Scripts that complete words of the program's commands.
std::string bash_completion(const std::vector<Command>& commands);
std::string zsh_completion(const std::vector<Command>& commands);
std::string fish_completion(const std::vector<Command>& commands);

}  // namespace weft::app
