#pragma once

#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// [m] mean length of the short edges of all triangles whose corners exist
double mean_cell_edge(const std::vector<Cloth>& cloths);

/// [m] contact thickness, also of a scene that gives none
double thickness_of(const Scene& scene);

/// Whether a scene has no materials, and its cloths name none.
bool takes_default_fabric(const Scene& scene);

/// Fills in the contact thickness and weld distances that the scene leaves empty. A scene without
/// materials gets the default fabric.
void fill_in_defaults(Scene& scene);

}  // namespace weft
