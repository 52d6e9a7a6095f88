#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"

// Pressure on a linear triangle, along its normal as it is now:
//   F = pressure (x1 - x0) x (x2 - x0) / 2,  a third of it to each corner
// For a closed surface, and for one whose border is held, this is the gradient of pressure times
// the volume inside: its Jacobian is symmetric once all triangles are summed.

namespace weft {

/// What pressure pushes each corner of a triangle with [N].
/// @param x        [m]  [3] x Vec3, corners; the normal is that of a counter-clockwise triangle
/// @param pressure [Pa] of what is behind the triangle over what is before it; of any sign
/// @cite bonet2008, pressure as a follower load
template <class T>
WEFT_HD constexpr Vec3<T> pressure_on_corner(const Vec3<T> x[3], T pressure) noexcept {
  return (pressure / T(6)) * cross(x[1] - x[0], x[2] - x[0]);
}

/// A triangle's share of the volume inside a closed surface [m^3]: that of its pyramid to the
/// origin.
template <class T>
WEFT_HD constexpr T volume_below(const Vec3<T> x[3]) noexcept {
  return dot(x[0], cross(x[1], x[2])) / T(6);
}

}  // namespace weft
