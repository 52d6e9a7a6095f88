#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/scalar.hpp"

namespace weft {

/// How a triangle lies in space, stretch apart: F = [x1-x0, x2-x0] * inv_rest = [axis0, axis1] S
/// with S symmetric and positive definite; axis2 is the normal.
template <class T>
struct TriangleFrame {
  Vec3<T> axis[3];       ///< orthonormal, right-handed; all zero where the triangle has no area
  T s00, s01, s11;       ///< S
  T det_inv, trace_inv;  ///< of S
};

/// The polar decomposition of a triangle's deformation gradient.
///   axis2 = f0 x f1 / |f0 x f1|,  axis0 = (f0 + f1 x axis2) / tr S,  axis1 = axis2 x axis0
/// @param x        [m]   [3] x Vec3, deformed corners
/// @param inv_rest [1/m] 2x2, inverse rest edges
template <class T>
WEFT_HD TriangleFrame<T> triangle_frame(const Vec3<T> x[3], const Mat2<T>& inv_rest) noexcept {
  using std::sqrt;
  const Vec3<T> a = x[1] - x[0];
  const Vec3<T> b = x[2] - x[0];
  const Vec3<T> f0 = a * inv_rest(0, 0) + b * inv_rest(1, 0);
  const Vec3<T> f1 = a * inv_rest(0, 1) + b * inv_rest(1, 1);
  const Vec3<T> normal = cross(f0, f1);
  const T det = length(normal);
  TriangleFrame<T> f{};
  // A triangle this thin has no normal that rounding leaves of use.
  if (!(det > T(64) * epsilon<T> * (length_sq(f0) + length_sq(f1)))) return f;
  f.det_inv = T(1) / det;
  f.axis[2] = normal * f.det_inv;
  const Vec3<T> along = f0 + cross(f1, f.axis[2]);
  f.trace_inv = T(1) / length(along);
  f.axis[0] = along * f.trace_inv;
  f.axis[1] = cross(f.axis[2], f.axis[0]);
  f.s00 = dot(f.axis[0], f0);
  f.s01 = (dot(f.axis[0], f1) + dot(f.axis[1], f0)) * T(0.5);
  f.s11 = dot(f.axis[1], f1);
  return f;
}

/// A vector from the frame's components.
template <class T>
WEFT_HD Vec3<T> from_frame(const TriangleFrame<T>& f, const Vec3<T>& c) noexcept {
  return f.axis[0] * c[0] + f.axis[1] * c[1] + f.axis[2] * c[2];
}

/// How the frame turns with the corners: the gradient of w . torque, where w is the frame's
/// rotation by small displacements of the corners. With b_j = axis2 . df_j and S as above
///   (w_1, -w_0) = -S^-1 b,  w_2 = (axis1 . df_0 - axis0 . df_1) / tr S
/// in components of the frame.
/// @param inv_rest [1/m] as for triangle_frame()
/// @param torque   [N m]
/// @param g        [N]   out, [3] x Vec3; sums to zero; zeros where the triangle has no area
template <class T>
WEFT_HD void triangle_frame_gradient(const TriangleFrame<T>& f, const Mat2<T>& inv_rest,
                                     const Vec3<T>& torque, Vec3<T> g[3]) noexcept {
  const T t0 = dot(f.axis[0], torque);
  const T t1 = dot(f.axis[1], torque);
  const T t2 = dot(f.axis[2], torque) * f.trace_inv;
  const T y0 = (f.s11 * t1 + f.s01 * t0) * f.det_inv;
  const T y1 = -(f.s01 * t1 + f.s00 * t0) * f.det_inv;
  const Vec3<T> by_f0 = f.axis[1] * t2 - f.axis[2] * y0;
  const Vec3<T> by_f1 = f.axis[0] * -t2 - f.axis[2] * y1;
  g[1] = by_f0 * inv_rest(0, 0) + by_f1 * inv_rest(0, 1);
  g[2] = by_f0 * inv_rest(1, 0) + by_f1 * inv_rest(1, 1);
  g[0] = -(g[1] + g[2]);
}

}  // namespace weft
