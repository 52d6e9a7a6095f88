#pragma once

#include <cmath>
#include <limits>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/distance.hpp"
#include "weft/elements/scalar.hpp"

// Certificates that two moving primitives stay apart.
//
// Corners move on straight lines, so the difference of a corner of the first primitive and one of
// the second is w(t) = w(0) + t (w(1) - w(0)). Every point difference of the primitives is a convex
// combination of these, so for any vector m, which may change with time,
//   m(t) . w(t) > reach |m(t)| for every pair of corners   =>   distance(t) > reach.     (1)
// m is a polynomial in h, the time since t, of degree at most 2: a fixed direction, one that stays
// across an edge, or one that stays across two (the normal of a face). Then (1) asks a polynomial,
// its height less its width, to be positive. Whatever m is, (1) holds: how it was found needs no
// trust, and all that can go wrong is rounding in the coefficients and in the test for their sign.
//
// Rounding. u = epsilon / 2, eta = the smallest normal number, s = |w(0)| + |w(1)| + eta,
// everything by components. Computed w(0) and w(1) are off by u |w|, so w(1) - w(0) by at most
// 2.1 u s, and w(t) = w(0) + t (w(1) - w(0)) by at most 6 u s; |w(t)|, |w(1) - w(0)| <= (1 + 2 u)
// s. (Underflow of the product costs u eta at most, which is in u s.) A dot product of 3 terms
// rounds by 3.1 u times the sum of their magnitudes, and a sum of two of them by 1.1 u more. With
// A_k = |m_k| . s the coefficient of h^k of the height is therefore off by at most
//   (6 + 3.1 + 1.1 + u') u (A_k + A_(k-1)) + eta < 8 epsilon (A_k + A_(k-1)) + eta,      (2)
// where eta is for underflow of the products, u' for what is of second order, and the difference of
// the two sides, 5 u (A_k + A_(k-1)), for rounding in subtracting (2) and the width from the
// height.
//   Width: by the inequality of means |m| <= N / 2 + |m|^2 / (2 N) for any N > 0, with equality at
// N = |m|. N = |m_0| is taken: a polynomial bound of |m(h)| that is exact to first order. Its
// coefficients are sums of products of the m_k; each is raised by 16 epsilon times the sum of the
// products' magnitudes (by Cauchy's inequality, |m_j| |m_k|), which is above 8 u for each of the
// rounded operations in it.
// With coefficients c_k that are below the true ones, so is the polynomial for h >= 0.

namespace weft::detail {

/// Differences of corner pairs (i of the first, j of the second primitive), as functions of time.
///   vertex-triangle, First = 1: 01 02 03     edge-edge, First = 2: 02 03 12 13
template <class T, int First>
struct PairMotion {
  static constexpr int pairs = First * (4 - First);
  Vec3<T> start[pairs];   ///< w(0)
  Vec3<T> end[pairs];     ///< w(1)
  Vec3<T> change[pairs];  ///< w(1) - w(0)
  Vec3<T> size[pairs];    ///< s of the head of this file
};

/// Directions m_0 + m_1 h + m_2 h^2.
/// @tparam Degree 0, 1 or 2: m_k = 0 for k above it
template <class T, int Degree>
struct Slab {
  Vec3<T> m[Degree + 1];
};

/// Coefficients of a polynomial in h.
template <class T, int Degree>
struct Polynomial {
  T c[Degree + 1];
};

/// Degree of the height less the width.
template <int Degree>
inline constexpr int slab_polynomial_degree = Degree < 2 ? Degree + 1 : 4;

/// Whether the direction is long enough for its square: where squares underflow, lengths are off
/// by less than sqrt(3 epsilon eta), and that is below 2 epsilon of this one.
template <class T, int Degree>
WEFT_HD bool slab_measurable(const Slab<T, Degree>& slab) noexcept {
  return length_sq(slab.m[0]) > smallest_normal<T> / epsilon<T>;
}

/// Upper bounds of the coefficients of reach |m(h)|, exact to first order.
template <class T, int Degree>
WEFT_HD Polynomial<T, 2 * Degree> slab_width(const Slab<T, Degree>& slab, T reach) noexcept {
  Polynomial<T, 2 * Degree> width{};
  if (!(reach > T(0))) return width;
  if (!slab_measurable(slab)) {
    width.c[0] = std::numeric_limits<T>::max();
    return width;
  }
  T norm[Degree + 1];
  for (int k = 0; k <= Degree; ++k) norm[k] = length(slab.m[k]);
  const T scale = reach / (T(2) * norm[0]);
  T magnitude[2 * Degree + 1] = {};
  for (int j = 0; j <= Degree; ++j)
    for (int k = 0; k <= Degree; ++k) {
      width.c[j + k] += dot(slab.m[j], slab.m[k]);
      magnitude[j + k] += norm[j] * norm[k];
    }
  for (int k = 0; k <= 2 * Degree; ++k)
    width.c[k] = scale * (width.c[k] + T(16) * epsilon<T> * magnitude[k]) + smallest_normal<T>;
  width.c[0] += T(0.5) * reach * norm[0] * (T(1) + T(16) * epsilon<T>);
  return width;
}

/// The same by the triangle inequality, for directions that soon are longer by far.
template <class T, int Degree>
WEFT_HD Polynomial<T, 2 * Degree> slab_width_far(const Slab<T, Degree>& slab, T reach) noexcept {
  Polynomial<T, 2 * Degree> width{};
  if (!(reach > T(0))) return width;
  if (!slab_measurable(slab)) {
    width.c[0] = std::numeric_limits<T>::max();
    return width;
  }
  for (int k = 0; k <= Degree; ++k)
    width.c[k] = reach * length(slab.m[k]) * (T(1) + T(16) * epsilon<T>)+smallest_normal<T>;
  return width;
}

/// Whether a polynomial is positive on [0, h]: its Bernstein coefficients are, of which its values
/// there are averages. They round by no more than 16 epsilon times the sum of all terms.
template <class T, int Degree>
WEFT_HD bool positive_until(const Polynomial<T, Degree>& p, T h) noexcept {
  using std::fabs;
  T term[Degree + 1];
  T power = T(1);
  T sum = T(0);
  for (int k = 0; k <= Degree; ++k) {
    term[k] = p.c[k] * power;
    sum += fabs(term[k]);
    power *= h;
  }
  const T floor = T(16) * epsilon<T> * sum + smallest_normal<T>;
  T least = term[0];
  for (int i = 1; i <= Degree; ++i) {
    T coefficient = term[0];
    T share = T(1);  // (i over k) / (Degree over k)
    for (int k = 1; k <= i; ++k) {
      share *= T(i - k + 1) / T(Degree - k + 1);
      coefficient += share * term[k];
    }
    least = lesser(coefficient, least);
  }
  return least > floor;
}

/// A time until which a polynomial is positive, at most h, for p.c[0] > 0: found from the minorant
/// p.c[0] - f(h), where f has the negative coefficients only. As f grows with h and f / h too, a
/// value of h at which f is above p.c[0] gives one below by p.c[0] / (f(h) / h).
template <class T, int Degree>
WEFT_HD T positive_time(const Polynomial<T, Degree>& p, T h) noexcept {
  T fall[Degree + 1];
  for (int k = 1; k <= Degree; ++k) fall[k] = greater(-p.c[k], T(0));
  const auto mean_fall = [&](T at) {  // f / h
    T f = fall[Degree];
    for (int k = Degree - 1; k >= 1; --k) f = f * at + fall[k];
    return f;
  };
  const T start = p.c[0] * (T(1) - T(32) * epsilon<T>);
  T time = h;
  for (int i = 0; i < 2; ++i) {
    const T below = start / mean_fall(time);
    if (!(below < h)) break;
    // Newton's step from below a root of a convex function ends above it.
    T slope = T(Degree) * fall[Degree];
    for (int k = Degree - 1; k >= 1; --k) slope = slope * below + T(k) * fall[k];
    time = lesser(below + (start - below * mean_fall(below)) / slope, time);
  }
  time = lesser(start / mean_fall(time), h) * (T(1) - T(8) * epsilon<T>);
  if (!(time * mean_fall(time) < p.c[0] * (T(1) - T(16) * epsilon<T>))) time = T(0);
  // The minorant leaves out that the polynomial may grow at first.
  if (!(p.c[1] > T(0))) return time;
  T longer = T(0.5) * h;
  for (int i = 0; i < 16 && longer > T(2) * time; ++i, longer *= T(0.25))
    if (positive_until(p, longer)) return longer;
  return time;
}

/// Lower bounds of the coefficients of height less width for one pair of corners.
template <class T, int Degree>
WEFT_HD Polynomial<T, slab_polynomial_degree<Degree>> slab_polynomial(
    const Slab<T, Degree>& slab, const Polynomial<T, 2 * Degree>& width, const Vec3<T>& w,
    const Vec3<T>& change, const Vec3<T>& size) noexcept {
  using std::fabs;
  Polynomial<T, slab_polynomial_degree<Degree>> p{};
  T error[slab_polynomial_degree<Degree> + 1] = {};
  for (int k = 0; k <= Degree; ++k) {
    const Vec3<T>& m = slab.m[k];
    p.c[k] += dot(m, w);
    p.c[k + 1] += dot(m, change);
    const T a = fabs(m[0]) * size[0] + fabs(m[1]) * size[1] + fabs(m[2]) * size[2];
    error[k] += a;
    error[k + 1] += a;
  }
  for (int k = 0; k <= Degree + 1; ++k) p.c[k] -= T(8) * epsilon<T> * error[k] + smallest_normal<T>;
  for (int k = 0; k <= 2 * Degree; ++k) p.c[k] -= width.c[k];
  return p;
}

/// Time, at most h, for which the slab keeps every pair of corners apart by more than reach.
/// @param w     differences of the corner pairs where h is zero
/// @param width an upper bound of reach |m(h)|
/// @return  zero where they are not apart to begin with
template <int First, class T, int Degree>
WEFT_HD T slab_time(const PairMotion<T, First>& motion, const Vec3<T>* w,
                    const Slab<T, Degree>& slab, const Polynomial<T, 2 * Degree>& width,
                    T h) noexcept {
  for (int i = 0; i < PairMotion<T, First>::pairs; ++i) {
    const auto p = slab_polynomial(slab, width, w[i], motion.change[i], motion.size[i]);
    if (!(p.c[0] > T(0))) return T(0);
    if (positive_until(p, h)) continue;
    h = positive_time(p, h);
    if (!(h > T(0))) return T(0);
  }
  return h;
}

/// A moving edge: e + h rate.
template <class T>
struct MovingEdge {
  Vec3<T> e, rate;
};

/// Edges of the primitives: vertex-triangle x1 to x2, x1 to x3, x2 to x3; edge-edge x0 to x1, x2 to
/// x3.
template <int First, class T>
WEFT_HD MovingEdge<T> moving_edge(const PairMotion<T, First>& motion, const Vec3<T>* w,
                                  int number) noexcept {
  int a, b;  // the corner pairs that differ by this edge
  if (First == 1) {
    a = number == 2 ? 1 : 0;
    b = number == 0 ? 1 : 2;
  } else {
    a = number == 0 ? 2 : 0;
    b = number == 0 ? 0 : 1;
  }
  return {w[a] - w[b], motion.change[a] - motion.change[b]};
}

/// With a slab that does not turn.
template <int First, class T>
WEFT_HD T slab_time_fixed(const PairMotion<T, First>& motion, const Vec3<T>* w,
                          const Vec3<T>& direction, T reach, T h) noexcept {
  const Slab<T, 0> slab{{direction}};
  return slab_time(motion, w, slab, slab_width(slab, reach), h);
}

/// The longer of the times for which a moving slab, and the same held as it is now, keep apart.
template <int First, class T, int Degree>
WEFT_HD T slab_time_longer(const PairMotion<T, First>& motion, const Vec3<T>* w,
                           const Slab<T, Degree>& slab, T reach, T h, bool thorough) noexcept {
  T time = slab_time_fixed(motion, w, slab.m[0], reach, h);
  if (!thorough || !(time < h)) return time;
  time = greater(slab_time(motion, w, slab, slab_width(slab, reach), h), time);
  if (!(reach > T(0)) || !(time < h)) return time;
  return greater(slab_time(motion, w, slab, slab_width_far(slab, reach), h), time);
}

/// With the slab across two edges: the normal of a face, or the common normal of two edges.
template <int First, class T>
WEFT_HD T slab_time_across_both(const PairMotion<T, First>& motion, const Vec3<T>* w,
                                const Vec3<T>& towards, T reach, T h, bool thorough) noexcept {
  const MovingEdge<T> a = moving_edge(motion, w, 0);
  const MovingEdge<T> b = moving_edge(motion, w, 1);
  Slab<T, 2> slab{
      {cross(a.e, b.e), cross(a.rate, b.e) + cross(a.e, b.rate), cross(a.rate, b.rate)}};
  if (dot(slab.m[0], towards) < T(0))
    for (Vec3<T>& m : slab.m) m = -m;
  return slab_time_longer(motion, w, slab, reach, h, thorough);
}

/// With the slab across one edge that is as nearly towards the other primitive as can be.
template <int First, class T>
WEFT_HD T slab_time_across_edge(const PairMotion<T, First>& motion, const Vec3<T>* w, int number,
                                const Vec3<T>& towards, T reach, T h, bool thorough) noexcept {
  const MovingEdge<T> a = moving_edge(motion, w, number);
  const Vec3<T> k = cross(towards, a.e);
  return slab_time_longer(motion, w, Slab<T, 1>{{cross(a.e, k), cross(a.rate, k)}}, reach, h,
                          thorough);
}

/// With the slab that goes with the closest features: their difference loses its direction to
/// rounding near contact, what is across an edge or a face does not.
template <int First, class T>
WEFT_HD T slab_time_likely(const PairMotion<T, First>& motion, const Vec3<T>* w,
                           const Proximity<T>& at, T reach, T h, bool thorough) noexcept {
  const unsigned active = active_corners(at);
  const Vec3<T>& towards = at.difference;
  int edge = -1;
  if (active == 15u) return slab_time_across_both(motion, w, towards, reach, h, thorough);
  if (First == 1)
    edge = active == 7u ? 0 : active == 11u ? 1 : active == 13u ? 2 : -1;
  else
    edge = (active & 3u) == 3u ? 0 : (active & 12u) == 12u ? 1 : -1;
  if (edge >= 0) return slab_time_across_edge(motion, w, edge, towards, reach, h, thorough);
  return slab_time_fixed(motion, w, towards, reach, h);
}

/// The longest time of all slabs that the closest points suggest.
template <int First, class T>
WEFT_HD T slab_time_any(const PairMotion<T, First>& motion, const Vec3<T>* w,
                        const Proximity<T>& at, T reach, T h) noexcept {
  const Vec3<T>& towards = at.difference;
  T best = slab_time_fixed(motion, w, towards, reach, h);
  best = greater(best, slab_time_across_both(motion, w, towards, reach, h, true));
  for (int edge = 0; edge < 4 - First; ++edge)
    best = greater(best, slab_time_across_edge(motion, w, edge, towards, reach, h, true));
  return best;
}

}  // namespace weft::detail
