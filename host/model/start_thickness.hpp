#pragma once

#include <vector>

#include "host/model/model.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Contact thickness of cloth that starts nearer to something than the scene's thickness: what is
/// at rest at the start stays at rest. Of each vertex it is the smallest gap of the pairs of
/// primitives that bear on it, but at least `rest_least` of the scene's thickness. Pairs with a
/// common vertex, pairs that seams tie, and neighbours on one cloth, whose rest distance is known,
/// do not count, and neither do gaps that miss the thickness by rounding only. A gap to an obstacle
/// counts only if it misses the thickness by more than the shortest edge at the vertex: a round
/// edge comes nearer to the middle of a triangle than to its corners, and cloth over it must not
/// stay thin.
/// @param model with positions at time 0, triangles, edges and ties
/// @return [cloth vertices] [m] at most contact.thickness; empty if no pair starts nearer than that
std::vector<double> start_thickness(const Scene& scene, const Model& model);

}  // namespace weft
