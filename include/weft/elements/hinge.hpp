#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/scalar.hpp"

// Discrete-shells hinge: energy = coefficient (theta - theta_rest)^2.
//
// Corners as in core/ids.hpp: x0, x1 on the edge, (x0, x1, x2) and (x1, x0, x3) counter-clockwise.
// theta is the angle from the normal of the first triangle to that of the second, in (-pi, pi],
// zero where flat, positive where the hinge is a ridge seen from the front (the normals spread) and
// negative where it is a valley.
//
// The angle is not defined on a triangle without area: where a triangle is no higher over the edge
// than rounding can tell, energies, angles and all derivatives are zero. Towards such triangles the
// derivatives grow as 1 / height, which is the formula and no error. The energy jumps where theta
// passes pi; gradients are finite on both sides.

namespace weft {

/// Coefficient of the hinge energy [J], for a plate of bending stiffness B.
///   coefficient = B / 2 edge_length^2 / (area_first + area_second)
/// On a grid of cells a x b cut into right triangles and bent to curvature kappa about the b side,
/// only the b edges bend, one a cell, by theta = kappa a: the sum over the hinges is
/// B / 2 kappa^2 a^2 b^2 / (a b) a cell, which is the integral of B / 2 kappa^2.
/// @param bending_stiffness [N m] B
/// @param edge_length       [m]   of the edge at rest
/// @param area_sum          [m^2] of both triangles at rest, > 0
/// @cite grinspun2003, flexural energy; its |e| / h_e, with h_e a third of the mean height, is
///       3 |e|^2 / (A1 + A2)
template <class T>
WEFT_HD constexpr T hinge_coefficient(T bending_stiffness, T edge_length, T area_sum) noexcept {
  return T(0.5) * bending_stiffness * edge_length * edge_length / area_sum;
}

namespace detail {

/// What the formulas share. Normals are not of unit length: normal = twice the area vector.
template <class T>
struct HingeFrame {
  Vec3<T> edge, arm2, arm3;  ///< x1 - x0, x2 - x0, x3 - x0
  Vec3<T> normal2, normal3;
  T edge_sq, normal2_sq, normal3_sq, edge_length;
  bool valid;  ///< false where a triangle has no area
};

template <class T>
WEFT_HD HingeFrame<T> hinge_frame(const Vec3<T> x[4]) noexcept {
  using std::sqrt;
  HingeFrame<T> f;
  f.edge = x[1] - x[0];
  f.arm2 = x[2] - x[0];
  f.arm3 = x[3] - x[0];
  f.normal2 = cross(f.edge, f.arm2);
  f.normal3 = cross(f.arm3, f.edge);
  f.edge_sq = length_sq(f.edge);
  f.normal2_sq = length_sq(f.normal2);
  f.normal3_sq = length_sq(f.normal3);
  f.edge_length = sqrt(f.edge_sq);
  // A cross product is off by some epsilon |edge| |arm|; a smaller one is noise.
  constexpr T noise = T(16) * epsilon<T> * T(16) * epsilon<T>;
  const T floor_sq = noise * f.edge_sq;
  f.valid = f.normal2_sq > floor_sq * greater(f.edge_sq, length_sq(f.arm2)) &&
            f.normal3_sq > floor_sq * greater(f.edge_sq, length_sq(f.arm3)) &&
            f.normal2_sq > smallest_normal<T> && f.normal3_sq > smallest_normal<T>;
  return f;
}

template <class T>
WEFT_HD T hinge_angle(const HingeFrame<T>& f) noexcept {
  using std::atan2;
  // This is -edge_length (arm2 . normal3) too, but where both triangles are thin that would be off
  // by the product of what either loses. Adding zero turns -0 into +0, so that a hinge folded flat
  // is at pi, not -pi.
  const T sine = dot(f.edge * (T(1) / f.edge_length), cross(f.normal2, f.normal3));
  return atan2(sine + T(0), dot(f.normal2, f.normal3));
}

template <class T>
WEFT_HD void hinge_angle_gradient(const HingeFrame<T>& f, Vec3<T> t[4]) noexcept {
  const T edge_sq_inv = T(1) / f.edge_sq;
  // Where the opposite corner's height meets the edge: 0 at x0, 1 at x1.
  const T foot2 = dot(f.arm2, f.edge) * edge_sq_inv;
  const T foot3 = dot(f.arm3, f.edge) * edge_sq_inv;
  t[2] = f.normal2 * (-f.edge_length / f.normal2_sq);
  t[3] = f.normal3 * (-f.edge_length / f.normal3_sq);
  t[0] = t[2] * (foot2 - T(1)) + t[3] * (foot3 - T(1));
  t[1] = -(t[2] * foot2 + t[3] * foot3);
}

}  // namespace detail

/// Signed dihedral angle [rad] in (-pi, pi], by atan2; zero where a triangle has no area.
/// @param x [m] [4] x Vec3, corners in the order of core/ids.hpp Hinge
template <class T>
WEFT_HD T hinge_angle(const Vec3<T> x[4]) noexcept {
  const auto f = detail::hinge_frame(x);
  return f.valid ? detail::hinge_angle(f) : T(0);
}

/// Gradient of hinge_angle; the parameters are the same.
/// @param t [rad/m] out, [4] x Vec3; sums to zero; zeros where a triangle has no area
/// @return  [rad]   the angle
/// @cite bridson2003, tamstorf2013
template <class T>
WEFT_HD T hinge_angle_gradient(const Vec3<T> x[4], Vec3<T> t[4]) noexcept {
  const auto f = detail::hinge_frame(x);
  if (!f.valid) {
    for (int i = 0; i < 4; ++i) t[i] = Vec3<T>{};
    return T(0);
  }
  detail::hinge_angle_gradient(f, t);
  return detail::hinge_angle(f);
}

/// Bending energy of one hinge [J]: coefficient (theta - theta_rest)^2.
/// @param x           [m]   [4] x Vec3, corners in the order of core/ids.hpp Hinge
/// @param theta_rest  [rad] angle at rest
/// @param coefficient [J]   from hinge_coefficient
/// @cite grinspun2003
template <class T>
WEFT_HD T hinge_energy(const Vec3<T> x[4], T theta_rest, T coefficient) noexcept {
  const auto f = detail::hinge_frame(x);
  if (!f.valid) return T(0);
  const T bend = detail::hinge_angle(f) - theta_rest;
  return coefficient * bend * bend;
}

/// Gradient of hinge_energy; the parameters are the same.
/// @param g [N] out, [4] x Vec3, dE/dx; the force is its negative; sums to zero
template <class T>
WEFT_HD void hinge_gradient(const Vec3<T> x[4], T theta_rest, T coefficient,
                            Vec3<T> g[4]) noexcept {
  const T theta = hinge_angle_gradient(x, g);
  const T slope = T(2) * coefficient * (theta - theta_rest);
  for (int i = 0; i < 4; ++i) g[i] *= slope;
}

/// Gradient of hinge_energy and its Gauss-Newton Hessian, which is positive semi-definite; the
/// parameters are the same. Block (i, j) of the Hessian is weight t[i] t[j]^T.
/// @param g [N]     out, [4] x Vec3, to the same bits as hinge_gradient
/// @param t [rad/m] out, [4] x Vec3, gradient of theta
/// @return  [J]     weight = 2 coefficient
template <class T>
WEFT_HD T hinge_gradient_hessian(const Vec3<T> x[4], T theta_rest, T coefficient, Vec3<T> g[4],
                                 Vec3<T> t[4]) noexcept {
  const T theta = hinge_angle_gradient(x, t);
  const T slope = T(2) * coefficient * (theta - theta_rest);
  for (int i = 0; i < 4; ++i) g[i] = t[i] * slope;
  return T(2) * coefficient;
}

}  // namespace weft
