#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

// Spring between two points that pulls only: slack at its rest length and below. d is the vector
// from the second point to the first. A guided spring acts along a fixed unit vector n: it sees
// only the part n (n . d) of d, and nothing resists motion across n. n = 0: it is not guided.

namespace weft {

/// What a spring sees of the vector between its points, [m].
/// @param d [m]   @param n unit vector or 0
template <class T>
WEFT_HD Vec3<T> spring_span(const Vec3<T>& d, const Vec3<T>& n) noexcept {
  return length_sq(n) > T(0) ? dot(n, d) * n : d;
}

/// Energy k/2 (|d| - rest)^2 where the spring is longer than at rest, else zero. [J]
/// @param d [m]   @param rest [m] >= 0   @param k [N/m]
template <class T>
WEFT_HD T spring_energy(const Vec3<T>& d, T rest, T k) noexcept {
  const T stretch = length(d) - rest;
  return stretch > T(0) ? T(0.5) * k * stretch * stretch : T(0);
}

/// Force on the first point, minus that on the second. [N]
template <class T>
WEFT_HD Vec3<T> spring_force(const Vec3<T>& d, T rest, T k) noexcept {
  const T now = length(d);
  return now > rest ? (k * (rest / now - T(1))) * d : Vec3<T>{};
}

/// Second derivative of the energy by the first point, [N/m]: k ((1 - rest/|d|) (I - n n^T) +
/// n n^T) with n along d. Never indefinite.
template <class T>
WEFT_HD Mat3<T> spring_stiffness(const Vec3<T>& d, T rest, T k) noexcept {
  const T now = length(d);
  if (now < rest) return {};
  if (!(rest > T(0))) return k * Mat3<T>::identity();
  const Vec3<T> n = (T(1) / now) * d;
  const Mat3<T> along = outer(n, n);
  return k * ((T(1) - rest / now) * (Mat3<T>::identity() - along) + along);
}

/// The same for a guided spring without length, k n n^T; not guided if n = 0.
/// @pre rest = 0 if n is not 0
template <class T>
WEFT_HD Mat3<T> spring_stiffness(const Vec3<T>& d, T rest, T k, const Vec3<T>& n) noexcept {
  return length_sq(n) > T(0) ? k * outer(n, n) : spring_stiffness(d, rest, k);
}

/// A dashpot beside the spring. It resists motion along the spring as it stood at the start of the
/// step, unless that was slack: the force on the first point is minus this times its displacement
/// in the step relative to the second point. [N/m]
/// @param d     [m] at the start of the step
/// @param drag  [N/m] damping [kg/s] over the length of the step
template <class T>
WEFT_HD Mat3<T> spring_drag(const Vec3<T>& d, T rest, T drag) noexcept {
  const T now = length(d);
  if (!(now > rest)) return {};
  const Vec3<T> n = (T(1) / now) * d;
  return drag * outer(n, n);
}

}  // namespace weft
