#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/app/view/player_run.hpp"

namespace weft::app {

/// The page without its data. The build makes it of page.html, page.css, page.js and three.js.
struct PageShell {
  std::string_view head;  ///< up to the data; empty: this program was built without three.js
  std::string_view tail;  ///< from there on
};

/// The shell that this program was built with.
PageShell built_shell();

/// One page that needs nothing else and asks for nothing else. Whatever the names in the runs are,
/// they stay data.
std::string player_page(const PageShell& shell, const std::vector<PlayerRun>& runs);

/// The page of a run that goes on. It asks the server that it comes from for news, and nobody else.
std::string live_page(const PageShell& shell, const PlayerRun& run);

}  // namespace weft::app
