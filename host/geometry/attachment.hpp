#pragma once

#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Where a point is held by a surface that moves: a point of one of its triangles, and the way from
/// there in a frame that turns along with the triangle.
struct Attachment {
  Tri corners{{0, 0, 0}};  ///< in the positions that it was made from
  Vec3<double> weights{};  ///< of the corners, not negative, sum 1
  Vec3<double> offset{};   ///< [m] along the first edge, across it, along the normal
};

/// Attaches each point to the nearest triangle, at equal distance to the first.
/// @param points    [n] [m]
/// @param triangles at least one, each with an area
/// @param positions [m] of their corners
/// @return          [n]
std::vector<Attachment> attach(const std::vector<Vec3<double>>& points, Span<const Tri> triangles,
                               Span<const Vec3<double>> positions);

/// Where the surface has taken the point. Lengths do not change where the triangle is stretched;
/// while it has no area, the point is on the triangle itself.
/// @param positions [m] of the same vertices at another time
/// @return          [m]
Vec3<double> attached_position(const Attachment& attachment, Span<const Vec3<double>> positions);

}  // namespace weft
