#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/scalar.hpp"

// Closest points of vertex and triangle, and of two edges.
//
// All arithmetic is on differences of the input points, so accuracy depends on the size of the
// primitives and of the gap between them, never on where they stand. The computed distance is that
// of two points of the primitives, and is off by no more than about ten epsilon times that size,
// for slivers, nearly parallel edges and edges of no length as well: the weights come from
// orthogonalisation (modified Gram-Schmidt), which is backward stable. They are the exact answer
// for corners moved by some epsilon of the size, and where they lie in the simplex that moves the
// least distance by no more. Weights themselves are as ill-determined as the configuration.

namespace weft {

/// Closest points of two primitives with four corners x0 .. x3 in all.
///   vertex-triangle (x0; x1, x2, x3): w = {1, -b0, -b1, -b2}
///   edge-edge (x0, x1; x2, x3):       w = {1 - s, s, -(1 - t), -t}
/// The weights of each primitive lie in its simplex: those clamped to its boundary are exactly 0.
template <class T>
struct Proximity {
  T distance_sq;       ///< [m^2]
  T w[4];              ///< [1]  sums to zero
  Vec3<T> difference;  ///< [m]  sum of w_j x_j, from the second primitive's point to the first's
};

/// The closest features: bit j is set where corner j bears on the closest points. Bits 1 to 3 of a
/// vertex-triangle, and each pair of bits of an edge-edge, tell vertex, edge and interior apart.
template <class T>
WEFT_HD constexpr unsigned active_corners(const Proximity<T>& p) noexcept {
  unsigned mask = 0;
  for (int j = 0; j < 4; ++j)
    if (p.w[j] != T(0)) mask |= 1u << j;
  return mask;
}

namespace detail {

/// The weights c1, c2 that minimise |r - c1 a - c2 b|; false where a and b do not span a plane.
/// @cite bjorck1967
template <class T>
WEFT_HD bool plane_weights(const Vec3<T>& r, const Vec3<T>& a, T a_sq, const Vec3<T>& b, T& c1,
                           T& c2) noexcept {
  if (!(a_sq > smallest_normal<T>)) return false;
  const T a_sq_inv = T(1) / a_sq;
  const T b_on_a = dot(a, b) * a_sq_inv;
  const T r_on_a = dot(a, r) * a_sq_inv;
  const Vec3<T> b_across = b - a * b_on_a;
  const T b_across_sq = length_sq(b_across);
  if (!(b_across_sq > smallest_normal<T>)) return false;
  // Stable only with r made orthogonal to a before it meets b.
  c2 = dot(b_across, r - a * r_on_a) / b_across_sq;
  c1 = r_on_a - b_on_a * c2;
  return true;
}

/// numerator / denominator clamped to [0, 1]; 0 where the segment has no length.
template <class T>
WEFT_HD T clamped_ratio(T numerator, T denominator) noexcept {
  if (!(numerator > T(0)) || !(denominator > T(0))) return T(0);
  return numerator < denominator ? numerator / denominator : T(1);
}

template <class T>
WEFT_HD Proximity<T> triangle_proximity(T b0, T b1, T b2, const Vec3<T>& difference) noexcept {
  return {length_sq(difference), {T(1), -b0, -b1, -b2}, difference};
}

template <class T>
WEFT_HD Proximity<T> edge_proximity(T s, T t, const Vec3<T>& difference) noexcept {
  return {length_sq(difference), {T(1) - s, s, t - T(1), -t}, difference};
}

template <class T>
WEFT_HD void keep_closer(Proximity<T>& best, const Proximity<T>& other) noexcept {
  if (other.distance_sq < best.distance_sq) best = other;
}

/// Closest point on the boundary of the triangle; r1, r2 from its corners 0 and 1 to the vertex.
template <class T>
WEFT_HD Proximity<T> vertex_triangle_boundary(const Vec3<T>& e1, T e1_sq, const Vec3<T>& e2,
                                              const Vec3<T>& r1, const Vec3<T>& e3,
                                              const Vec3<T>& r2) noexcept {
  const T t1 = clamped_ratio(dot(r1, e1), e1_sq);
  const T t2 = clamped_ratio(dot(r1, e2), length_sq(e2));
  const T t3 = clamped_ratio(dot(r2, e3), length_sq(e3));
  Proximity<T> best = triangle_proximity(T(1) - t1, t1, T(0), r1 - e1 * t1);
  keep_closer(best, triangle_proximity(T(1) - t2, T(0), t2, r1 - e2 * t2));
  keep_closer(best, triangle_proximity(T(0), T(1) - t3, t3, r2 - e3 * t3));
  return best;
}

/// Closest points of two edges where one of them is at an end; r = first edge's start minus the
/// second's.
template <class T>
WEFT_HD Proximity<T> edge_edge_boundary(const Vec3<T>& d1, T d1_sq, const Vec3<T>& d2,
                                        const Vec3<T>& r) noexcept {
  const T d2_sq = length_sq(d2);
  const T along = dot(d1, d2);
  const T r1 = dot(r, d1);
  const T r2 = dot(r, d2);
  const T t_at0 = clamped_ratio(r2, d2_sq);
  const T t_at1 = clamped_ratio(r2 + along, d2_sq);
  const T s_at0 = clamped_ratio(-r1, d1_sq);
  const T s_at1 = clamped_ratio(along - r1, d1_sq);
  const Vec3<T> r_end1 = r + d1;
  const Vec3<T> r_end2 = r - d2;
  Proximity<T> best = edge_proximity(T(0), t_at0, r - d2 * t_at0);
  keep_closer(best, edge_proximity(T(1), t_at1, r_end1 - d2 * t_at1));
  keep_closer(best, edge_proximity(s_at0, T(0), r + d1 * s_at0));
  keep_closer(best, edge_proximity(s_at1, T(1), r_end2 + d1 * s_at1));
  return best;
}

/// Whether the plane normal to e1 and e2 keeps points that differ by r farther apart than d, in
/// spite of rounding.
template <class T>
WEFT_HD bool plane_gap_exceeds(const Vec3<T>& e1, const Vec3<T>& e2, const Vec3<T>& r,
                               T d) noexcept {
  using std::fabs;
  using std::sqrt;
  const Vec3<T> n = cross(e1, e2);
  const T n_sq = length_sq(n);
  // Relative error bounds do not hold where squares underflow.
  if (!(n_sq > smallest_normal<T> / epsilon<T>)) return false;
  const T size =
      (fabs(e1[0]) + fabs(e1[1]) + fabs(e1[2])) * (fabs(e2[0]) + fabs(e2[1]) + fabs(e2[2]));
  const T reach = fabs(r[0]) + fabs(r[1]) + fabs(r[2]) + d;
  constexpr T slack = T(16) * epsilon<T>;
  return fabs(dot(n, r)) > d * sqrt(n_sq) + slack * size * reach + smallest_normal<T>;
}

/// Gap between the intervals [lo_a, hi_a] and [lo_b, hi_b], zero or less where they overlap. As
/// rounding keeps order, gap > d holds in exact arithmetic if it holds here.
template <class T>
WEFT_HD T interval_gap(T lo_a, T hi_a, T lo_b, T hi_b) noexcept {
  return greater(lo_a - hi_b, lo_b - hi_a);
}

}  // namespace detail

/// Closest points of a vertex and a triangle.
/// @param x [m] [4] x Vec3: the vertex, then the triangle's corners
/// @return  distance, weights and difference; finite for any finite x, whatever the triangle
/// @cite ericson2005, section 5.1.5, for the case analysis; the arithmetic departs from it
template <class T>
WEFT_HD Proximity<T> vertex_triangle(const Vec3<T> x[4]) noexcept {
  const Vec3<T> e1 = x[2] - x[1];
  const Vec3<T> e2 = x[3] - x[1];
  const Vec3<T> r = x[0] - x[1];
  const T e1_sq = length_sq(e1);
  T b1 = T(0), b2 = T(0);
  if (detail::plane_weights(r, e1, e1_sq, e2, b1, b2) && b1 >= T(0) && b2 >= T(0) &&
      b1 + b2 <= T(1))
    return detail::triangle_proximity(T(1) - (b1 + b2), b1, b2, r - e1 * b1 - e2 * b2);
  return detail::vertex_triangle_boundary(e1, e1_sq, e2, r, x[3] - x[2], x[0] - x[2]);
}

/// Closest points of two edges.
/// @param x [m] [4] x Vec3: the ends of the first edge, then of the second
/// @return  distance, weights and difference; finite for any finite x, whatever the edges; where
///          parallel edges have many closest pairs, one of those with an end
/// @cite ericson2005, section 5.1.9, for the case analysis; the arithmetic departs from it
template <class T>
WEFT_HD Proximity<T> edge_edge(const Vec3<T> x[4]) noexcept {
  const Vec3<T> d1 = x[1] - x[0];
  const Vec3<T> d2 = x[3] - x[2];
  const Vec3<T> r = x[0] - x[2];
  const T d1_sq = length_sq(d1);
  T c1 = T(0), t = T(0);
  if (detail::plane_weights(r, d1, d1_sq, d2, c1, t)) {
    const T s = -c1;
    if (s >= T(0) && s <= T(1) && t >= T(0) && t <= T(1))
      return detail::edge_proximity(s, t, r + d1 * s - d2 * t);
  }
  return detail::edge_edge_boundary(d1, d1_sq, d2, r);
}

/// Cheap test whether a vertex and a triangle are farther apart than d [m], d >= 0: by their boxes,
/// then by the plane of the triangle. True only where it is so, rounding included; false may be
/// either.
template <class T>
WEFT_HD bool vertex_triangle_farther(const Vec3<T> x[4], T d) noexcept {
  for (int i = 0; i < 3; ++i) {
    const T lo = lesser(lesser(x[1][i], x[2][i]), x[3][i]);
    const T hi = greater(greater(x[1][i], x[2][i]), x[3][i]);
    if (detail::interval_gap(x[0][i], x[0][i], lo, hi) > d) return true;
  }
  return detail::plane_gap_exceeds(x[2] - x[1], x[3] - x[1], x[0] - x[1], d);
}

/// Cheap test whether two edges are farther apart than d [m], d >= 0: by their boxes, then by the
/// two parallel planes through them. True only where it is so, rounding included; false may be
/// either.
template <class T>
WEFT_HD bool edge_edge_farther(const Vec3<T> x[4], T d) noexcept {
  for (int i = 0; i < 3; ++i) {
    const T gap = detail::interval_gap(lesser(x[0][i], x[1][i]), greater(x[0][i], x[1][i]),
                                       lesser(x[2][i], x[3][i]), greater(x[2][i], x[3][i]));
    if (gap > d) return true;
  }
  return detail::plane_gap_exceeds(x[1] - x[0], x[3] - x[2], x[0] - x[2], d);
}

}  // namespace weft
