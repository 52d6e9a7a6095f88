#pragma once

#include <vector>

#include "weft/core/ids.hpp"

namespace weft {

/// Reverse Cuthill-McKee order: neighbours get numbers that are close, so that what a vertex reads
/// of its neighbours is in the cache.
/// @param count of vertices
/// @param edges between vertices below `count`; others are passed over
/// @return      [count] the vertices in their new order
/// @cite cuthill1969
std::vector<Index> reverse_cuthill_mckee(Index count, const std::vector<Edge>& edges);

}  // namespace weft
