#pragma once

#include <cmath>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/distance.hpp"
#include "weft/elements/scalar.hpp"

// Continuous collision detection with minimum separation, by conservative advancement, in double.
//
// Each corner moves on a straight line from x_t0 at time 0 to x_t1 at time 1. The search starts at
// time 0 and steps forward only as far as a bound on the motion proves that the distance stays
// above the separation, so that a collision can be reported too early or in vain, never missed:
//   no false negative: if the exact distance is <= separation at some time in [0, 1], hit is true,
//     and toi is 0 or less than the first such time;
//   false positives: only where the distance falls to separation + 2 tolerance, with tolerance the
//     greater of 0.1 min(separation, d0 - separation) and the rounding error, or where the
//     iterations run out (some in ten thousand of fast grazing motions at separation 0, rarer
//     above).
// If the primitives start within the separation (or above it by less than the tolerance), the
// answer is a hit at time 0, even where they part. Callers therefore pass
//   separation = min(wanted separation, 0.9 d0);
// touching primitives (d0 = 0) hit at time 0 whatever is passed, and so does input that is not
// finite.

namespace weft {

/// The outcome of continuous collision detection.
struct Impact {
  bool hit;              ///< whether the primitives come within the separation
  double toi;            ///< [1] time of impact in [0, 1], 1 without a hit
  Proximity<double> at;  ///< closest points at toi; of no meaning without a hit
};

namespace detail {

/// At this number of steps the answer is a hit at the time that was reached.
inline constexpr int ccd_iterations_max = 512;

/// Corners relative to the first one, and their displacements less the mean displacement: the
/// distance depends on neither, and small numbers round less.
struct CcdMotion {
  Vec3<double> start[4];
  Vec3<double> displacement[4];
  double size;  ///< [m] largest coordinate that went in, for rounding errors
};

WEFT_HD inline CcdMotion ccd_motion(const Vec3<double> x_t0[4],
                                    const Vec3<double> x_t1[4]) noexcept {
  using std::fabs;
  CcdMotion m;
  double start_max = 0;
  double displacement_max = 0;
  Vec3<double> mean{};
  for (int j = 0; j < 4; ++j) {
    m.start[j] = x_t0[j] - x_t0[0];
    m.displacement[j] = x_t1[j] - x_t0[j];
    mean += m.displacement[j] * 0.25;
    for (int i = 0; i < 3; ++i) {
      start_max = greater(fabs(m.start[j][i]), start_max);
      displacement_max = greater(fabs(m.displacement[j][i]), displacement_max);
    }
  }
  for (int j = 0; j < 4; ++j) m.displacement[j] -= mean;
  // The last term is zero, or NaN if any input is not finite: every test below then fails towards
  // a hit.
  m.size = start_max + displacement_max + 0 * (mean[0] + mean[1] + mean[2]);
  return m;
}

/// Whether the boxes of the whole motions of corners [0, first) and [first, 4) are farther apart
/// than d.
WEFT_HD inline bool ccd_boxes_farther(const CcdMotion& m, int first, double d) noexcept {
  for (int i = 0; i < 3; ++i) {
    double lo[2], hi[2];
    for (int side = 0; side < 2; ++side) {
      const int begin = side == 0 ? 0 : first;
      const int end = side == 0 ? first : 4;
      lo[side] = hi[side] = m.start[begin][i];
      for (int j = begin; j < end; ++j) {
        const double a = m.start[j][i];
        const double b = a + m.displacement[j][i];
        lo[side] = lesser(lo[side], lesser(a, b));
        hi[side] = greater(hi[side], greater(a, b));
      }
    }
    if (interval_gap(lo[0], hi[0], lo[1], hi[1]) > d) return true;
  }
  return false;
}

/// Time for which the slab between the primitives stays wider than floor: along the unit vector u
/// the distance is at least the least of u . (x_i - x_j) over the corners i of the first and j of
/// the second primitive, each of which is linear in time. Lets primitives slide along each other in
/// one step, where a bound on the speed alone needs many.
/// @return zero or less where the slab is no wider than floor already
WEFT_HD inline double ccd_slab_time(const Vec3<double> x[4], const Vec3<double> displacement[4],
                                    int first, const Vec3<double>& u, double floor) noexcept {
  double height[4], speed[4];
  for (int j = 0; j < 4; ++j) {
    height[j] = dot(u, x[j]);
    speed[j] = dot(u, displacement[j]);
  }
  double time = 2;  // more than the whole motion
  for (int i = 0; i < first; ++i)
    for (int j = first; j < 4; ++j) {
      const double room = height[i] - height[j] - floor;
      const double closing = speed[j] - speed[i];
      if (!(room > 0)) return 0;
      if (closing * time > room) time = room / closing;
    }
  return time;
}

/// Unit vector across both primitives, towards the first; zero where they span no plane. Near
/// contact it is far more exact than the difference of the closest points, which rounding turns.
WEFT_HD inline Vec3<double> ccd_common_normal(const Vec3<double> x[4], int first,
                                              const Vec3<double>& difference) noexcept {
  const Vec3<double> along = first == 1 ? x[2] - x[1] : x[1] - x[0];
  const Vec3<double> n = cross(along, x[3] - x[first == 1 ? 1 : 2]);
  const double size = length(n);
  if (!(size > smallest_normal<double>)) return {};
  return n * ((dot(n, difference) < 0 ? -1 : 1) / size);
}

/// Most that the distance can shrink in unit time.
WEFT_HD inline double ccd_closing_speed(const CcdMotion& m, int first) noexcept {
  using std::sqrt;
  double speed_sq[2] = {0, 0};
  for (int j = 0; j < 4; ++j) {
    double& side = speed_sq[j < first ? 0 : 1];
    side = greater(length_sq(m.displacement[j]), side);
  }
  return sqrt(speed_sq[0]) + sqrt(speed_sq[1]);
}

/// Corners [0, First) are the first primitive: 1 for vertex-triangle, 2 for edge-edge.
template <int First>
WEFT_HD Impact ccd(const Vec3<double> x_t0[4], const Vec3<double> x_t1[4],
                   double separation) noexcept {
  using std::sqrt;
  const CcdMotion m = ccd_motion(x_t0, x_t1);
  // What a computed distance can exceed the true one by, from rounding in the positions and in the
  // search for the closest points.
  const double error = 128 * epsilon<double> * m.size;
  const Impact miss{false, 1, {}};
  if (ccd_boxes_farther(m, First, separation + error)) return miss;
  const double closing_speed = ccd_closing_speed(m, First);
  double time = 0;
  double tolerance = error;
  Vec3<double> x[4];
  for (int iteration = 0;; ++iteration) {
    for (int j = 0; j < 4; ++j) x[j] = m.start[j] + m.displacement[j] * time;
    const Proximity<double> at = First == 1 ? vertex_triangle(x) : edge_edge(x);
    const double distance = sqrt(at.distance_sq);
    const double gap = distance - error - separation;
    if (iteration == 0) tolerance = greater(error, 0.1 * lesser(separation, gap));
    if (!(gap > tolerance) || iteration == ccd_iterations_max) return {true, time, at};
    // To stop short of the separation by half the tolerance leaves every step some length, and toi
    // before the true time.
    const double room = gap - 0.5 * tolerance;
    if (!(room < closing_speed * (1 - time))) return miss;
    double step = room / closing_speed;
    const double floor = separation + error + 0.5 * tolerance;
    const auto slab_time = [&](const Vec3<double>& u) {
      return ccd_slab_time(x, m.displacement, First, u, floor);
    };
    const double slab_step = slab_time(at.difference * (1 / distance));
    if (slab_step > step)
      step = slab_step;
    else
      step = greater(step, slab_time(ccd_common_normal(x, First, at.difference)));
    time += step;
    if (!(time < 1)) return miss;
  }
}

}  // namespace detail

/// First time at which a vertex and a triangle come within the separation.
/// @param x_t0       [m] [4] x Vec3, the vertex and the triangle's corners at time 0
/// @param x_t1       [m] the same at time 1
/// @param separation [m] >= 0; less than the distance at time 0, or the answer is a hit at time 0
/// @return  conservative, as the head of this file says; at = vertex_triangle at time toi
/// @cite li2021, additive conservative advancement; departs from it in the bound
///       along a direction (after tang2009), in the stopping rule and in counting rounding
WEFT_HD inline Impact ccd_vertex_triangle(const Vec3<double> x_t0[4], const Vec3<double> x_t1[4],
                                          double separation) noexcept {
  return detail::ccd<1>(x_t0, x_t1, separation);
}

/// First time at which two edges come within the separation.
/// @param x_t0       [m] [4] x Vec3, the ends of the first edge, then of the second, at time 0
/// @param x_t1       [m] the same at time 1
/// @param separation [m] >= 0; less than the distance at time 0, or the answer is a hit at time 0
/// @return  conservative, as the head of this file says; at = edge_edge at time toi
/// @cite li2021, as ccd_vertex_triangle
WEFT_HD inline Impact ccd_edge_edge(const Vec3<double> x_t0[4], const Vec3<double> x_t1[4],
                                    double separation) noexcept {
  return detail::ccd<2>(x_t0, x_t1, separation);
}

}  // namespace weft
