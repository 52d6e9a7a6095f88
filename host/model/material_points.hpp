#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Appends a point of each vertex in material space, with the pieces of a pattern side by side:
/// where pieces meet, that of the first triangle.
/// @param points [m] those of other meshes so far
void append_material_points(const Mesh& mesh, std::vector<Vec2<double>>& points);

/// Corners of a triangle in material space. [m]
std::array<Vec2<double>, 3> material_corners(const Mesh& mesh, std::size_t triangle);

}  // namespace weft
