#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// x turned about an axis through the origin by Cayley's rotation.
/// @param half [1] along the axis; its length is the tangent of half the angle
template <class T>
WEFT_HD Vec3<T> cayley_turned(const Vec3<T>& x, const Vec3<T>& half) noexcept {
  const Vec3<T> across = cross(half, x);
  return x + (T(2) / (T(1) + dot(half, half))) * (across + cross(half, across));
}

/// By how much small displacements of its corners turn a triangle. About axes in its plane that is
/// how its normal turns. About its normal n, with columns f_k of the deformation gradient and d_k
/// of its change, it is n . sum(f_k x d_k) / sum(f_k . f_k), the rotation nearest to the change if
/// the triangle is little strained.
/// @param edge     [m]   [2] x1 - x0, x2 - x0
/// @param moved    [m]   [2] how the edges change
/// @param inv_rest [1/m] 2x2, inverse rest edges
/// @return [rad] 0 where the triangle has no area
template <class T>
WEFT_HD Vec3<T> triangle_rotation(const Vec3<T> edge[2], const Vec3<T> moved[2],
                                  const Mat2<T>& inv_rest) noexcept {
  const Vec3<T> normal = cross(edge[0], edge[1]);
  const T area_sq = dot(normal, normal);
  if (!(area_sq > T(0))) return {};
  T curl = T(0);
  T size = T(0);
  for (int k = 0; k < 2; ++k) {
    const Vec3<T> f = edge[0] * inv_rest(0, k) + edge[1] * inv_rest(1, k);
    const Vec3<T> d = moved[0] * inv_rest(0, k) + moved[1] * inv_rest(1, k);
    curl += dot(cross(f, d), normal);
    size += dot(f, f);
  }
  const Vec3<T> tilt = dot(moved[1], normal) * edge[0] - dot(moved[0], normal) * edge[1];
  return (T(1) / area_sq) * (tilt + (curl / size) * normal);
}

}  // namespace weft
