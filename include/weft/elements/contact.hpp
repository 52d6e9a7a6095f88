#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"

// Linearised repulsion and Coulomb friction of one proximity.
//
// The normal n is a unit vector from the second primitive to the first and is held fixed while
// forces are taken, so that the gap g = n . sum of w_j x_j is linear in the corners: with f the
// force of repulsion, corner j feels w_j f n, and the stiffness between corners i and j is
// k w_i w_j n n^T. In friction u is the tangential displacement of the first primitive against the
// second from where the contact would be at ease: the anchor, which is carried from step to step,
// and on top of it what sum of w_j (x_j - x_j at the step's start) has across n. Up to Coulomb's
// limit corner j feels -w_j k u, beyond it the anchor slides and the force keeps to the limit.

namespace weft {

/// Share of their distance at rest at which neighbours on one cloth start to repel each other,
/// where that is less than the thickness.
inline constexpr double rest_share = 0.9;

/// [thicknesses] Pairs that would repel below that only are left to the continuous test: of so
/// little a gap a penalty would have to be as stiff as a wall.
inline constexpr double rest_least = 0.01;

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

/// Friction per displacement [N/m] of a contact that sticks like a spring until Coulomb's limit:
/// min(k, limit / y). Times the displacement it is the force; used as a stiffness as well it is
/// positive, and a motion that slows down is never turned round by it.
/// @param k     [N/m] stiffness of sticking, > 0
/// @param limit [N] coefficient of friction times normal force, >= 0
/// @param y     [m] tangential displacement from where the contact would be at ease, >= 0
template <class T>
WEFT_HD constexpr T friction_drag(T k, T limit, T y) noexcept {
  return k * y <= limit ? k : limit / y;
}

/// Potential of friction [J] with the normal force held fixed: k/2 y^2 while sticking, beyond that
/// limit y - limit^2 / (2 k). Its derivative by y is y friction_drag.
template <class T>
WEFT_HD constexpr T friction_potential(T k, T limit, T y) noexcept {
  return k * y <= limit ? T(0.5) * k * y * y : limit * (y - T(0.5) * limit / k);
}

/// Friction about some displacement: against u it is limit slide + stiffness u', with u' the part
/// of u across `slide`.
template <class T>
struct FrictionTangent {
  T stiffness;    ///< [N/m]
  T limit;        ///< [N]
  Vec3<T> slide;  ///< unit vector, or zero where the contact sticks
};

/// Tangent of friction at the displacement u; beyond the limit the force goes with the direction of
/// u alone.
/// @param k, limit as in friction_drag
template <class T>
WEFT_HD FrictionTangent<T> friction_tangent(T k, T limit, const Vec3<T>& u) noexcept {
  const T y = length(u);
  if (k * y <= limit) return {k, T(0), Vec3<T>{}};
  return {limit / y, limit, u * (T(1) / y)};
}

/// What friction resists the displacement u with. [N]
template <class T>
WEFT_HD Vec3<T> friction_force(const FrictionTangent<T>& f, const Vec3<T>& u) noexcept {
  return f.slide * f.limit + (u - f.slide * dot(f.slide, u)) * f.stiffness;
}

/// What is left of a tangential displacement u [m] when the step is over: where it exceeds what
/// sticking can hold, the anchor has slid along.
/// @param k, limit as in friction_drag
template <class T>
WEFT_HD Vec3<T> anchor_after(const Vec3<T>& u, T k, T limit) noexcept {
  const T y = length(u);
  return k * y <= limit ? u : u * (limit / (k * y));
}

/// The anchor of a contact whose normal was `before`, now that it is `after`: turned by the
/// smallest rotation that takes one to the other, so that a contact which turns with its bodies
/// goes on holding.
/// @param anchor [m] across `before`   @param before, after [1] unit
template <class T>
WEFT_HD Vec3<T> turned_anchor(const Vec3<T>& anchor, const Vec3<T>& before,
                              const Vec3<T>& after) noexcept {
  const T opposite = T(1) + dot(before, after);
  if (!(opposite > T(0.1))) return Vec3<T>{};  // it has gone round to the other side
  return anchor - (before + after) * (dot(anchor, after) / opposite);
}

}  // namespace weft
