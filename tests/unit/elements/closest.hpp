#pragma once

#include <algorithm>
#include <cmath>

#include "tests/unit/elements/configurations.hpp"
#include "weft/core/vec.hpp"

// Distances by other means than the ones under test: in long double, by least squares with
// orthogonalised directions; and by search over the weights.

namespace weft::test {

/// Distance from the origin to the segment a, b.
inline Long segment_reference(const Vec3<Long>& a, const Vec3<Long>& b) {
  const Vec3<Long> e = b - a;
  const Long e_sq = length_sq(e);
  const Long t = e_sq > 0 ? std::clamp(-dot(a, e) / e_sq, 0.0L, 1.0L) : 0.0L;
  return length(a + e * t);
}

/// Weights s, t that minimise |r + s a + t b|, by orthogonalising twice; false where a and b are
/// parallel to within rounding.
inline bool least_squares(const Vec3<Long>& r, const Vec3<Long>& a, const Vec3<Long>& b, Long& s,
                          Long& t) {
  const Long la = length(a);
  if (!(la > 0)) return false;
  const Vec3<Long> q1 = a * (1 / la);
  Vec3<Long> rest = b - q1 * dot(q1, b);
  const Long again = dot(q1, rest);
  rest -= q1 * again;
  const Long lb = length(rest);
  if (!(lb > 1e-18L * length(b))) return false;
  const Vec3<Long> q2 = rest * (1 / lb);
  const Vec3<Long> out = r - q1 * dot(q1, r);
  t = -dot(q2, out) / lb;
  s = -dot(q1, r + b * t) / la;
  return true;
}

/// Distance of vertex x[0] and triangle x[1], x[2], x[3].
inline Long vertex_triangle_reference(const Vec3<Long> (&local)[4]) {
  Vec3<Long> p[3];
  for (int j = 0; j < 3; ++j) p[j] = local[j + 1] - local[0];
  Long d = std::min({segment_reference(p[0], p[1]), segment_reference(p[1], p[2]),
                     segment_reference(p[2], p[0])});
  Long s = 0, t = 0;
  if (least_squares(p[0], p[1] - p[0], p[2] - p[0], s, t) && s >= 0 && t >= 0 && s + t <= 1)
    d = std::min(d, length(p[0] + (p[1] - p[0]) * s + (p[2] - p[0]) * t));
  return d;
}

/// Distance of edge x[0], x[1] and edge x[2], x[3].
inline Long edge_edge_reference(const Vec3<Long> (&x)[4]) {
  Long d = std::min(
      {segment_reference(x[2] - x[0], x[3] - x[0]), segment_reference(x[2] - x[1], x[3] - x[1]),
       segment_reference(x[0] - x[2], x[1] - x[2]), segment_reference(x[0] - x[3], x[1] - x[3])});
  const Vec3<Long> r = x[0] - x[2], a = x[1] - x[0], b = x[2] - x[3];
  Long s = 0, t = 0;
  if (least_squares(r, a, b, s, t) && s >= 0 && s <= 1 && t >= 0 && t <= 1)
    d = std::min(d, length(r + a * s + b * t));
  return d;
}

inline Long vertex_triangle_reference(const Vec3<double> (&x)[4]) {
  Vec3<Long> y[4];
  cast(x, y);
  return vertex_triangle_reference(y);
}

inline Long edge_edge_reference(const Vec3<double> (&x)[4]) {
  Vec3<Long> y[4];
  cast(x, y);
  return edge_edge_reference(y);
}

/// Least value of a convex f over [0, hi], by golden sections.
template <class F>
double golden_search(const F& f, double hi) {
  constexpr double ratio = 0.6180339887498949;
  double lo = 0, u = hi - ratio * hi, v = ratio * hi;
  double best = std::min(f(lo), f(hi)), fu = f(u), fv = f(v);
  for (int i = 0; i < 56; ++i) {
    best = std::min({best, fu, fv});
    if (fu < fv) {
      hi = v, v = u, fv = fu;
      u = hi - ratio * (hi - lo), fu = f(u);
    } else {
      lo = u, u = v, fu = fv;
      v = lo + ratio * (hi - lo), fv = f(v);
    }
  }
  return std::min({best, fu, fv});
}

/// Distance of vertex and triangle by search over the weights of the corners.
inline double vertex_triangle_search(const Vec3<double> (&x)[4]) {
  const Vec3<double> r = x[0] - x[1], a = x[2] - x[1], b = x[3] - x[1];
  const auto least = [&](double u) {
    return golden_search([&](double v) { return length(r - a * u - b * v); }, 1 - u);
  };
  return golden_search(least, 1);
}

/// Distance of two edges by search over the weights of their ends.
inline double edge_edge_search(const Vec3<double> (&x)[4]) {
  const Vec3<double> r = x[0] - x[2], a = x[1] - x[0], b = x[3] - x[2];
  const auto least = [&](double s) {
    return golden_search([&](double t) { return length(r + a * s - b * t); }, 1);
  };
  return golden_search(least, 1);
}

}  // namespace weft::test
