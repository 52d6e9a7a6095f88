#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"

// Linearised repulsion and smoothed Coulomb friction of one proximity.
//
// The normal n is a unit vector from the second primitive to the first and is held fixed while
// forces are taken, so that the gap g = n . sum of w_j x_j is linear in the corners: with f the
// force of repulsion, corner j feels w_j f n, and the stiffness between corners i and j is
// k w_i w_j n n^T. In friction u is the relative displacement sum of w_j (x_j - x_j at the step's
// start) without its part along n, y its length, and corner j feels -w_j friction_coefficient u.

namespace weft {

/// Unit normal of a contact.
/// @param difference [m] Proximity::difference
/// @param fallback   [1] unit vector, the answer where the primitives touch
template <class T>
WEFT_HD Vec3<T> contact_normal(const Vec3<T>& difference, const Vec3<T>& fallback) noexcept {
  const T d = length(difference);
  return d > T(0) ? difference * (T(1) / d) : fallback;
}

/// Gap g = n . sum of w_j x_j [m], negative where the primitives have passed each other. Taken
/// relative to x[0], as the weights sum to zero.
/// @param n [1]     unit normal, from second to first primitive
/// @param x [m]     [4] x Vec3, corners
/// @param w [1] [4] weights of Proximity
template <class T>
WEFT_HD T contact_gap(const Vec3<T>& n, const Vec3<T> x[4], const T w[4]) noexcept {
  const Vec3<T> between = (x[1] - x[0]) * w[1] + (x[2] - x[0]) * w[2] + (x[3] - x[0]) * w[3];
  return dot(n, between);
}

/// Energy of repulsion [J]: k/2 (h - g)^2 for g < h, else zero.
/// @param g [m] gap   @param h [m] gap at which repulsion starts   @param k [N/m] stiffness
template <class T>
WEFT_HD constexpr T repulsion_energy(T g, T h, T k) noexcept {
  return g < h ? T(0.5) * k * (h - g) * (h - g) : T(0);
}

/// Force of repulsion along n [N]: k (h - g) for g < h, else zero; minus the derivative of
/// repulsion_energy by the gap.
template <class T>
WEFT_HD constexpr T repulsion_force(T g, T h, T k) noexcept {
  return g < h ? k * (h - g) : T(0);
}

/// The part of a displacement across the normal.
/// @param u [m] displacement   @param n [1] unit normal
template <class T>
WEFT_HD constexpr Vec3<T> tangential(const Vec3<T>& u, const Vec3<T>& n) noexcept {
  return u - n * dot(u, n);
}

/// f1(y) / y [1/m], where f1(y) = 2 y/eps - (y/eps)^2 for y < eps, else 1: the share of the Coulomb
/// limit that friction reaches. Finite at y = 0.
/// @param y   [m] tangential displacement, >= 0
/// @param eps [m] displacement at which friction is in full, > 0: a slip speed times the step
/// @cite li2020, section 5
template <class T>
WEFT_HD constexpr T friction_scale(T y, T eps) noexcept {
  return y < eps ? (T(2) - y / eps) / eps : T(1) / y;
}

/// f0(y) [m] with f0' = f1: y^2/eps - y^3/(3 eps^2) + eps/3 for y < eps, else y. Times mu and the
/// normal force, the potential of friction.
/// @param y   [m] tangential displacement, >= 0   @param eps [m] > 0
/// @cite li2020, section 5
template <class T>
WEFT_HD constexpr T friction_potential(T y, T eps) noexcept {
  if (!(y < eps)) return y;
  const T r = y / eps;
  return y * r * (T(1) - r / T(3)) + eps / T(3);
}

/// Friction per tangential displacement [N/m]: mu normal_force f1(y) / y. Used as a stiffness with
/// I - n n^T as well, it leaves out the (negative) change of f1(y) / y and stays positive
/// semi-definite.
/// @param mu           [1] coefficient of friction, >= 0
/// @param normal_force [N] >= 0, held fixed while forces are taken
/// @param y            [m] tangential displacement, >= 0   @param eps [m] > 0
template <class T>
WEFT_HD constexpr T friction_coefficient(T mu, T normal_force, T y, T eps) noexcept {
  return mu * normal_force * friction_scale(y, eps);
}

}  // namespace weft
