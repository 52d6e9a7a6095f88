#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/scalar.hpp"

// When four moving corners lie in one plane.
//
// Corners on straight lines make D(t) = n(t) . r(t), n(t) = a(t) x b(t), a cubic, for edges a, b of
// the primitives (two of the triangle, or one each) and r from one primitive to the other. The
// planes normal to n through the two primitives are |D| / |n| apart, and so are the primitives at
// least:
//   |D(t)| > reach |n(t)|   =>   distance(t) > reach.
// With a0, a1 the vector a at times 0 and 1, and so on, D and n have the Bernstein coefficients
//   D_0 = [a0 b0 r0]    3 D_1 = [a1 b0 r0] + [a0 b1 r0] + [a0 b0 r1]    n_0 = a0 x b0
//   D_3 = [a1 b1 r1]    3 D_2 = [a0 b1 r1] + [a1 b0 r1] + [a1 b1 r0]    n_2 = a1 x b1
//   n_1 = (a0 x b1 + a1 x b0) / 2,
// and are averages of them: |n(t)| <= N, the greatest of the |n_k|. So |D| > reach N will do.
//
// Rounding. u = epsilon / 2. Each component of a0 ... r1 is one difference of given numbers, off by
// u of itself; a triple product has 6 terms, each of them 3 differences, 2 products and at most 4
// sums, over which 3 such products are added by 2 more and divided: less than 13 u of it. With
// A, B, R the largest components of a, b, r the coefficients are off by less than
//   13 u 6 A B R (1 + O(u)) < 40 epsilon A B R.
// Averages of coefficients are taken by de Casteljau's algorithm: 3 levels of 3 roundings each,
// less than 5 epsilon of the largest coefficient, itself below 6 A B R (1 + O(u)): 31 epsilon A B
// R, and twice where the cubic is cut at both ends: 102 epsilon A B R in all. N is at most 4 A B (1
// + O(u)), off by less than 8 epsilon of that. Coplanarity::error holds 128 epsilon A B (R + reach)
// for all this and its own rounding, and eta, the smallest normal number, for underflow.

namespace weft::detail {

/// Bernstein coefficients of D on [0, 1], oriented so that the first is not negative.
template <class T>
struct Coplanarity {
  T d[4];
  T error;  ///< most that d, or an average of it, is off by, and reach N
};

/// Length of a vector, or a number above it where squares underflow.
template <class T>
WEFT_HD T length_bound(const Vec3<T>& v) noexcept {
  using std::fabs;
  using std::sqrt;
  const T square = length_sq(v);
  if (square > smallest_normal<T> / epsilon<T>) return sqrt(square);
  return T(2) * greater(fabs(v[0]), greater(fabs(v[1]), fabs(v[2])));
}

/// @param a, b, r at times 0 and 1, each component one rounded difference
/// @param reach   >= 0
template <class T>
WEFT_HD Coplanarity<T> coplanarity(const Vec3<T> a[2], const Vec3<T> b[2], const Vec3<T> r[2],
                                   T reach) noexcept {
  using std::fabs;
  const Vec3<T> n0 = cross(a[0], b[0]);
  const Vec3<T> n1 = cross(a[0], b[1]) + cross(a[1], b[0]);
  const Vec3<T> n2 = cross(a[1], b[1]);
  Coplanarity<T> p;
  p.d[0] = dot(n0, r[0]);
  p.d[1] = (dot(n1, r[0]) + dot(n0, r[1])) * (T(1) / T(3));
  p.d[2] = (dot(n1, r[1]) + dot(n2, r[0])) * (T(1) / T(3));
  p.d[3] = dot(n2, r[1]);
  if (p.d[0] < T(0))
    for (int k = 0; k < 4; ++k) p.d[k] = -p.d[k];
  T size[3] = {};
  for (int i = 0; i < 2; ++i)
    for (int c = 0; c < 3; ++c) {
      size[0] = greater(fabs(a[i][c]), size[0]);
      size[1] = greater(fabs(b[i][c]), size[1]);
      size[2] = greater(fabs(r[i][c]), size[2]);
    }
  const T n_max = greater(length_bound(n0), greater(T(0.5) * length_bound(n1), length_bound(n2)));
  p.error = T(128) * epsilon<T> * size[0] * size[1] * (size[2] + reach) + reach * n_max +
            T(64) * smallest_normal<T>;
  return p;
}

/// D on [t, 1], oriented so that the first coefficient is not negative.
template <class T>
WEFT_HD Coplanarity<T> coplanarity_after(const Coplanarity<T>& p, T t) noexcept {
  const T s = T(1) - t;
  Coplanarity<T> q = p;
  for (int level = 1; level < 4; ++level)
    for (int k = 0; k < 4 - level; ++k) q.d[k] = q.d[k] * s + q.d[k + 1] * t;
  if (q.d[0] < T(0))
    for (int k = 0; k < 4; ++k) q.d[k] = -q.d[k];
  return q;
}

/// Whether |D| > reach |n| on all of [0, t].
template <class T>
WEFT_HD bool never_coplanar(const Coplanarity<T>& p, T t) noexcept {
  const T s = T(1) - t;
  T q[4] = {p.d[0], p.d[1], p.d[2], p.d[3]};
  T least = q[0];
  for (int level = 1; level < 4; ++level) {
    for (int k = 0; k < 4 - level; ++k) q[k] = q[k] * s + q[k + 1] * t;
    least = lesser(q[0], least);
  }
  return least > p.error;
}

/// Estimate of the first root of D on [0, 1].
template <class T>
struct CoplanarTime {
  bool found;
  T time;
  T doubt;  ///< how long before and after |D| is within error
};

/// Finds the first simple root by Newton's method, kept within a shrinking bracket. Nothing is
/// proven here.
/// @pre d[0] > 0
template <class T>
WEFT_HD CoplanarTime<T> first_coplanar(const Coplanarity<T>& p) noexcept {
  using std::fabs;
  using std::sqrt;
  const T* d = p.d;
  const T c1 = T(3) * (d[1] - d[0]);
  const T c2 = T(3) * (d[2] - T(2) * d[1] + d[0]);
  const T c3 = d[3] - d[0] + T(3) * (d[1] - d[2]);
  const auto value = [&](T t) { return d[0] + t * (c1 + t * (c2 + t * c3)); };
  const auto slope = [&](T t) { return c1 + t * (T(2) * c2 + T(3) * t * c3); };
  T lo = T(0), hi = T(1);
  // One change of sign in d: one root. More: D turns, and falls below zero at its least first.
  if (!(d[3] < T(0)) || (d[1] < T(0) && d[2] > T(0))) {
    const T square = c2 * c2 - T(3) * c1 * c3;
    if (!(square > T(0))) return {d[3] < T(0), T(0), T(1)};
    const T root = sqrt(square);
    // Where the slope is zero and grows; written so that nothing cancels.
    const T least = c2 > T(0) ? -c1 / (c2 + root) : (root - c2) / (T(3) * c3);
    if (least > T(0) && least < T(1) && value(least) < T(0))
      hi = least;
    else if (!(d[3] < T(0)))
      return {false, T(1), T(1)};
  }
  T t = lo + (hi - lo) * (d[0] / (d[0] - value(hi)));
  for (int i = 0; i < 24; ++i) {
    const T v = value(t);
    if (fabs(v) <= T(0.125) * p.error) return {true, t, p.error / fabs(slope(t))};
    (v > T(0) ? lo : hi) = t;
    t -= v / slope(t);
    if (!(t > lo && t < hi)) t = T(0.5) * (lo + hi);
  }
  return {false, t, T(1)};
}

}  // namespace weft::detail
