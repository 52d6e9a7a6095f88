#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "weft/seam_state.hpp"

namespace weft::app {

/// One line on the seams that are open: which, how many of their pairs, and the largest gap. It
/// names the first few.
/// @param due_only only seams that should have closed
/// @return empty if there are none
std::string open_seams_text(const std::vector<SeamState>& seams, bool due_only);

/// The part "seams" of a report.
nlohmann::ordered_json seams_json(const std::vector<SeamState>& seams);

}  // namespace weft::app
