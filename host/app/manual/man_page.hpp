#pragma once

#include <string>
#include <vector>

#include "host/app/manual/command_list.hpp"

namespace weft::app {

/// weft(1), in the macros of man(7).
std::string man_page(const std::vector<Command>& commands);

}  // namespace weft::app
