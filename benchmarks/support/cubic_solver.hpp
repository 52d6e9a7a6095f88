#pragma once

#include <algorithm>
#include <cmath>

#include "weft/core/vec.hpp"
#include "weft/elements/distance.hpp"

// What textbooks do: roots of the cubic of coplanarity, in order, and whether the primitives touch
// there to within a tolerance. For comparison only: rounding makes it miss contacts.

namespace weft::bench {

/// Roots of c0 + c1 t + c2 t^2 + c3 t^3 in [0, 1] in ascending order, by bisection and Newton's
/// method between the turning points.
/// @param roots [3]
/// @return their number
inline int cubic_roots(const double c[4], double roots[3]) {
  const auto value = [&](double t) { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); };
  const auto slope = [&](double t) { return c[1] + t * (2 * c[2] + 3 * t * c[3]); };
  double ends[4] = {0, 1, 1, 1};
  int pieces = 1;
  const double square = c[2] * c[2] - 3 * c[1] * c[3];
  if (square > 0) {
    // Both roots of the derivative, without cancellation.
    const double q = -(c[2] + std::copysign(std::sqrt(square), c[2]));
    double turn[2] = {q / (3 * c[3]), c[1] / q};
    if (!(turn[0] < turn[1])) std::swap(turn[0], turn[1]);
    for (const double t : turn)
      if (t > ends[pieces - 1] && t < 1) ends[pieces++] = t;
    ends[pieces] = 1;
  }
  int count = 0;
  for (int i = 0; i < pieces; ++i) {
    double lo = ends[i], hi = ends[i + 1];
    const double at_lo = value(lo), at_hi = value(hi);
    if (at_lo * at_hi > 0) continue;
    double t = at_lo == at_hi ? lo : lo + (hi - lo) * at_lo / (at_lo - at_hi);
    for (int n = 0; n < 50; ++n) {
      const double v = value(t);
      if ((v < 0) == (at_lo < 0))
        lo = t;
      else
        hi = t;
      double next = t - v / slope(t);
      if (!(next >= lo && next <= hi)) next = 0.5 * (lo + hi);
      const double moved = std::fabs(next - t);
      t = next;
      if (moved < 1e-14) break;
    }
    roots[count++] = t;
  }
  return count;
}

/// @param toi first time at which they seem to touch; unchanged without one
/// @return whether they seem to touch
inline bool plain_cubic_ccd(bool edges, const Vec3<double> x_t0[4], const Vec3<double> x_t1[4],
                            double& toi) {
  const int first = edges ? 2 : 1;
  Vec3<double> a[2], b[2], r[2];
  for (int i = 0; i < 2; ++i) {
    const Vec3<double>* x = i == 0 ? x_t0 : x_t1;
    a[i] = edges ? x[1] - x[0] : x[2] - x[1];
    b[i] = x[3] - x[first];
    r[i] = x[0] - x[first];
  }
  const Vec3<double> da = a[1] - a[0], db = b[1] - b[0], dr = r[1] - r[0];
  const Vec3<double> n0 = cross(a[0], b[0]), n1 = cross(da, b[0]) + cross(a[0], db),
                     n2 = cross(da, db);
  const double c[4] = {dot(n0, r[0]), dot(n1, r[0]) + dot(n0, dr), dot(n2, r[0]) + dot(n1, dr),
                       dot(n2, dr)};
  double roots[3];
  const int count = cubic_roots(c, roots);
  for (int i = 0; i < count; ++i) {
    Vec3<double> x[4];
    double size = 0;
    for (int j = 0; j < 4; ++j) {
      x[j] = x_t0[j] + (x_t1[j] - x_t0[j]) * roots[i];
      size = std::max(size, length_sq(x[j] - x[0]));
    }
    const double distance_sq = (edges ? edge_edge(x) : vertex_triangle(x)).distance_sq;
    if (distance_sq > 1e-20 * size) continue;
    toi = roots[i];
    return true;
  }
  return false;
}

}  // namespace weft::bench
