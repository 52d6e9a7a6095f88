#pragma once

#include <array>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

using Corners = std::array<Vec3<double>, 3>;  ///< [m] of a triangle

/// Gap below which features count as touching, in units of the longest side of the triangles'
/// boxes. Far above the rounding of a transform or a distance, far below any gap made on purpose.
inline constexpr double touching = 1e-12;

/// True where the inside of the segment pq runs through the inside of the triangle; exact.
/// @param p,q [m] ends of the segment   @param t [m] corners
bool pierces(const Vec3<double>& p, const Vec3<double>& q, const Corners& t);

/// True if a plane across the line of centres, along a face, or upright on one along an edge, keeps
/// the triangles farther apart than `gap` in spite of rounding. False may be either.
/// @param gap [m]
bool plainly_apart(const Corners& s, const Corners& t, double gap);

/// Whether features of the two triangles that share no vertex touch, or one pierces the other.
/// Two triangles that have a point in common other than a shared vertex or edge always do so: where
/// their common part ends, an edge of one runs into the other.
/// @param s_tri,t_tri numbers of the corners, by which shared ones are known
/// @param s,t         [m] the corners
bool triangles_intersect(const Tri& s_tri, const Tri& t_tri, const Corners& s, const Corners& t);

}  // namespace weft
