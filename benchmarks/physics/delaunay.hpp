#pragma once

#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft::physics {

/// Delaunay triangulation of a rectangle by insertion and flips (Lawson 1977).
/// @param points   the rectangle's corners, counter-clockwise from the lower left, then points on
///                 its sides, then points within; none twice
/// @param on_sides how many follow the corners on the sides
/// @return counter-clockwise triangles in ascending order; no vertex of them is missing
/// Where four points lie on a circle a tiny displacement that is a function of the point's number
/// decides, so that the answer is the same everywhere.
std::vector<Tri> triangulate_rectangle(const std::vector<Vec2<double>>& points,
                                       std::size_t on_sides);

}  // namespace weft::physics
