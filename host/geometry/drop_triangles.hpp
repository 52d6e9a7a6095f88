#pragma once

#include <cstddef>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Removes triangles of a mesh, with their material corners and groups. Vertices stay.
/// @param marked [triangles] true: to be removed
/// @return       how many were removed
std::size_t drop_triangles(Mesh& mesh, const std::vector<bool>& marked);

}  // namespace weft
