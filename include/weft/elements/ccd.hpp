#pragma once

#include <cmath>
#include <limits>

#include "weft/core/hd.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/coplanarity.hpp"
#include "weft/elements/distance.hpp"
#include "weft/elements/moving_slab.hpp"
#include "weft/elements/scalar.hpp"

// Continuous collision detection with minimum separation.
//
// Each corner moves on a straight line from x_t0 at time 0 to x_t1 at time 1. The search marches
// through time. It moves on only over spans for which one of these certificates proves, rounding
// counted, that the distance stays above the separation:
//   - the boxes of the two motions stand apart (first of all, over the whole span);
//   - the corners are not coplanar, or the planes of the primitives are farther apart than the
//     separation (coplanarity.hpp), which carries it to shortly before the next root of a cubic;
//   - a slab that turns with the primitives parts them (moving_slab.hpp); which slab is guessed
//     from the closest points where the search stands.
// So a collision can be reported too early or in vain, never missed:
//   no false negative: if the exact distance is <= separation at some time in [0, 1], hit is true,
//     and toi is no later than the first such time. The search ends with no hit only when
//     certificates cover [0, 1], each from where the one before ended: ends are rounded down;
//   false positives: where the search stops, for one of the reasons in Ending below.
// Steps are bounded, each is bounded work, and there is no recursion. Where a compiler fuses
// multiplications and additions the bounds hold as well: that only leaves out roundings.
//
// Boxes. A component of a corner difference is off by u = epsilon / 2 of itself, and is between its
// values at times 0 and 1; a gap g between the computed ones is one of at least g (1 - u).
// Time. With t, h >= 0 and t + h <= 1, fl(fl(t + h) (1 - epsilon)) <= (t + h) (1 + u)^2 (1 - 2 u)
// < t + h. The rest of the time, 1 - t rounded, is raised by 2 epsilon.
// Range. Sizes beyond 2^64 (2^8 in float) or below its inverse are first scaled by a power of two,
// exactly but for underflow, which the certificates' eta covers. So nothing overflows.
// Input. If a coordinate given is within e of the true one at both times, then so it is in between,
// and the distance is within 2 sqrt(3) e of the true one: the separation is raised by that.
//
// Ending. The answer is a hit at the time that was reached
//   - where the corners are just about to cross a plane, well within both primitives, so that there
//     certainly is an impact, after no more than sqrt(epsilon) of the time;
//   - where no certificate leads on: the distance there is within rounding of the separation (some
//     10 epsilon of the size of primitives and motion), more for slivers;
//   - where it is above the separation by less than ccd_tolerance of that;
//   - after ccd_steps_max steps, which takes a long dance at the brink of contact.
// Callers that may start close pass separation = min(wanted separation, 0.9 distance at the start).
// Touching primitives hit at time 0 whatever is passed, and so does input that is not finite.

namespace weft {

/// The outcome of continuous collision detection.
template <class T>
struct Impact {
  bool hit;         ///< whether the primitives come within the separation
  T toi;            ///< [1] time of impact in [0, 1], 1 without a hit
  Proximity<T> at;  ///< closest points at toi; of no meaning without a hit
};

namespace detail {

/// At this number of steps the answer is a hit at the time that was reached.
inline constexpr int ccd_steps_max = 64;

/// A distance above the separation by this share of it counts as contact, to save steps.
inline constexpr double ccd_tolerance = 1e-3;

/// What the search knows of a query.
template <class T, int First>
struct CcdQuery {
  PairMotion<T, First> motion;
  Coplanarity<T> coplanar;
  T reach;  ///< separation, and what uncertain input adds
  T size;   ///< largest component of motion.size
};

/// Corner pairs, as PairMotion numbers them.
template <class T, int First>
WEFT_HD PairMotion<T, First> ccd_motion(const Vec3<T> x_t0[4], const Vec3<T> x_t1[4]) noexcept {
  using std::fabs;
  PairMotion<T, First> motion;
  for (int n = 0; n < PairMotion<T, First>::pairs; ++n) {
    const int i = First == 1 ? 0 : n / 2;
    const int j = First == 1 ? n + 1 : 2 + n % 2;
    for (int c = 0; c < 3; ++c) {
      const T start = x_t0[i][c] - x_t0[j][c];
      const T end = x_t1[i][c] - x_t1[j][c];
      motion.start[n][c] = start;
      motion.end[n][c] = end;
      motion.change[n][c] = end - start;
      motion.size[n][c] = fabs(start) + fabs(end) + smallest_normal<T>;
    }
  }
  return motion;
}

/// Gap between the boxes of the two motions along an axis, negative where they overlap.
template <class T, int First>
WEFT_HD T ccd_box_gap(const PairMotion<T, First>& motion) noexcept {
  T gap = -std::numeric_limits<T>::max();
  for (int c = 0; c < 3; ++c) {
    T lo = motion.start[0][c];
    T hi = lo;
    for (int n = 0; n < PairMotion<T, First>::pairs; ++n) {
      lo = lesser(lo, lesser(motion.start[n][c], motion.end[n][c]));
      hi = greater(hi, greater(motion.start[n][c], motion.end[n][c]));
    }
    gap = greater(gap, greater(lo, -hi));
  }
  return gap;
}

/// Largest component of motion.size, NaN or infinite if any is not finite.
template <class T, int First>
WEFT_HD T ccd_size(const PairMotion<T, First>& motion) noexcept {
  T most = T(0);
  T finite = T(0);
  for (int n = 0; n < PairMotion<T, First>::pairs; ++n)
    for (int c = 0; c < 3; ++c) {
      most = greater(motion.size[n][c], most);
      finite += T(0) * motion.size[n][c];
    }
  return most + finite;
}

/// The cubic of two edges and a corner difference, all times scale.
template <int First, class T>
WEFT_HD Coplanarity<T> ccd_coplanarity(const Vec3<T> x_t0[4], const Vec3<T> x_t1[4], T scale,
                                       T reach) noexcept {
  Vec3<T> a[2], b[2], r[2];
  for (int i = 0; i < 2; ++i) {
    const Vec3<T>* x = i == 0 ? x_t0 : x_t1;
    a[i] = (First == 1 ? x[2] - x[1] : x[1] - x[0]) * scale;
    b[i] = (x[3] - x[First]) * scale;
    r[i] = (x[0] - x[First]) * scale;
  }
  return coplanarity(a, b, r, reach);
}

/// The power of two by which a size has to be multiplied to be in range, 1 if it is.
template <class T>
WEFT_HD T ccd_scale(T size) noexcept {
  using std::frexp;
  using std::ldexp;
  constexpr T most = T(sizeof(T) == sizeof(double) ? 0x1p64 : 0x1p8);
  if (size <= most && size * most >= T(1)) return T(1);
  int exponent = 0;
  frexp(size, &exponent);
  constexpr int exponent_max = std::numeric_limits<T>::max_exponent - 1;
  return ldexp(T(1), -exponent < exponent_max ? -exponent : exponent_max);
}

/// How far the search can move on because the corners are not coplanar.
template <class T>
struct CoplanarJump {
  T time;         ///< until which they are certainly not coplanar nor within reach of it
  T look_after;   ///< time from which on another jump may lead farther
  bool crossing;  ///< whether they certainly are just after
};

/// @param whole D on [0, 1]
template <class T>
WEFT_HD CoplanarJump<T> ccd_jump(const Coplanarity<T>& whole, T time) noexcept {
  const Coplanarity<T> p = time > T(0) ? coplanarity_after(whole, time) : whole;
  if (!(p.d[0] > p.error)) return {time, time, false};
  if (lesser(lesser(p.d[0], p.d[1]), lesser(p.d[2], p.d[3])) > p.error) return {T(1), T(2), false};
  const CoplanarTime<T> root = first_coplanar(p);
  if (!root.found) return {time, T(2), false};
  const T rest = T(1) - time;
  const T after = time + (root.time + T(2) * root.doubt) * rest;
  const T before = root.time - T(2) * root.doubt - T(8) * epsilon<T>;
  if (!(before > T(0)) || !never_coplanar(p, before)) return {time, after, false};
  const T next = (time + before * rest * (T(1) - T(4) * epsilon<T>)) * (T(1) - epsilon<T>);
  const bool crossing = root.doubt * root.doubt < epsilon<T>;
  return {greater(next, time), after, crossing};
}

/// Whether the closest points are well within both primitives.
template <class T>
WEFT_HD bool ccd_well_within(const Proximity<T>& at) noexcept {
  using std::fabs;
  T least = T(1);
  for (int j = 0; j < 4; ++j) least = lesser(fabs(at.w[j]), least);
  return least * least > epsilon<T>;
}

/// Corners from their pairs' differences, the first corner at the origin: good enough to guess
/// from.
template <int First, class T>
WEFT_HD Proximity<T> ccd_closest(const Vec3<T>* w) noexcept {
  if constexpr (First == 1) {
    const Vec3<T> x[4] = {{}, -w[0], -w[1], -w[2]};
    return vertex_triangle(x);
  } else {
    const Vec3<T> x[4] = {{}, w[2] - w[0], -w[0], -w[1]};
    return edge_edge(x);
  }
}

template <int First, class T>
WEFT_HD Impact<T> ccd_march(const CcdQuery<T, First>& q) noexcept {
  using std::sqrt;
  constexpr int pairs = PairMotion<T, First>::pairs;
  const PairMotion<T, First>& motion = q.motion;
  const T rounding = T(16) * epsilon<T> * q.size;
  const T tolerance = T(ccd_tolerance) * q.reach;
  T time = T(0);
  T look_after = T(0);
  T gap_before = T(0);
  int effort = 0;
  for (int step = 0;; ++step) {
    bool crossing = false;
    if (time >= look_after) {
      const CoplanarJump<T> jump = ccd_jump(q.coplanar, time);
      if (jump.time == T(1)) return {false, T(1), {}};
      time = jump.time;
      look_after = jump.look_after;
      crossing = jump.crossing;
    }
    Vec3<T> w[pairs];
    for (int n = 0; n < pairs; ++n) w[n] = motion.start[n] + motion.change[n] * time;
    const Proximity<T> at = ccd_closest<First>(w);
    const Impact<T> hit{true, time, at};
    if (step == ccd_steps_max || (crossing && ccd_well_within(at))) return hit;
    const T gap = sqrt(at.distance_sq) - q.reach;
    if (gap < tolerance) return hit;
    const T rest = (T(1) - time) * (T(1) + T(2) * epsilon<T>);
    if (step > 0) effort = gap > T(0.25) * gap_before ? effort + 1 : 0;
    T h = slab_time_likely(motion, w, at, q.reach, rest, effort > 0);
    if (effort > 1 || (!(h > T(0)) && gap > rounding))
      h = greater(h, slab_time_any(motion, w, at, q.reach, rest));
    if (!(h < rest)) return {false, T(1), {}};
    const T next = (time + h) * (T(1) - epsilon<T>);
    if (!(next > time)) return hit;
    time = next;
    gap_before = gap;
  }
}

/// Corners [0, First) are the first primitive: 1 for vertex-triangle, 2 for edge-edge.
template <int First, class T>
WEFT_HD Impact<T> ccd(const Vec3<T> x_t0[4], const Vec3<T> x_t1[4], T separation,
                      T input_error) noexcept {
  CcdQuery<T, First> q;
  q.motion = ccd_motion<T, First>(x_t0, x_t1);
  q.reach = (separation + T(3.4642) * input_error) * (T(1) + T(4) * epsilon<T>);
  q.size = ccd_size(q.motion);
  const Impact<T> miss{false, T(1), {}};
  if (!(q.size <= std::numeric_limits<T>::max()))
    return {true, T(0), ccd_closest<First>(q.motion.start)};
  if (ccd_box_gap(q.motion) * (T(1) - T(2) * epsilon<T>) > q.reach) return miss;
  const T scale = ccd_scale(q.size);
  if (scale == T(1)) {
    q.coplanar = ccd_coplanarity<First>(x_t0, x_t1, T(1), q.reach);
    return ccd_march(q);
  }
  for (int n = 0; n < PairMotion<T, First>::pairs; ++n) {
    q.motion.start[n] *= scale;
    q.motion.change[n] *= scale;
    q.motion.size[n] *= scale;
    for (int c = 0; c < 3; ++c) q.motion.size[n][c] += smallest_normal<T>;
  }
  q.reach = q.reach > T(0) ? q.reach * scale * (T(1) + T(4) * epsilon<T>)+smallest_normal<T> : T(0);
  q.size *= scale;
  q.coplanar = ccd_coplanarity<First>(x_t0, x_t1, scale, q.reach);
  Impact<T> impact = ccd_march(q);
  const T back = T(1) / scale;
  impact.at.difference *= back;
  impact.at.distance_sq *= back * back;
  return impact;
}

}  // namespace detail

/// First time at which a vertex and a triangle come within the separation.
/// @param x_t0        [m] [4] x Vec3, the vertex and the triangle's corners at time 0
/// @param x_t1        [m] the same at time 1
/// @param separation  [m] >= 0; less than the distance at time 0, or the answer is a hit at time 0
/// @param input_error [m] most that a given coordinate differs from the true one, such as
///                    rounding_of_input; the answer is about the true ones
/// @return  conservative, as the head of this file says; at = vertex_triangle at time toi
/// @cite li2021, additive conservative advancement, and tang2009, its bound along a direction;
///       departs from them in directions that turn with the primitives, in jumps to the roots of
///       the cubic, in the stopping rule and in counting rounding
template <class T>
WEFT_HD Impact<T> ccd_vertex_triangle(const Vec3<T> x_t0[4], const Vec3<T> x_t1[4], T separation,
                                      T input_error = T(0)) noexcept {
  return detail::ccd<1>(x_t0, x_t1, separation, input_error);
}

/// First time at which two edges come within the separation.
/// @param x_t0        [m] [4] x Vec3, the ends of the first edge, then of the second, at time 0
/// @param x_t1        [m] the same at time 1
/// @param separation  [m] >= 0; less than the distance at time 0, or the answer is a hit at time 0
/// @param input_error [m] as ccd_vertex_triangle
/// @return  conservative, as the head of this file says; at = edge_edge at time toi
/// @cite as ccd_vertex_triangle
template <class T>
WEFT_HD Impact<T> ccd_edge_edge(const Vec3<T> x_t0[4], const Vec3<T> x_t1[4], T separation,
                                T input_error = T(0)) noexcept {
  return detail::ccd<2>(x_t0, x_t1, separation, input_error);
}

/// Most that coordinates that were rounded to the nearest T can be off by. [m]
/// @param x_t0, x_t1 [m] [4] x Vec3, after rounding
template <class T>
WEFT_HD T rounding_of_input(const Vec3<T> x_t0[4], const Vec3<T> x_t1[4]) noexcept {
  using std::fabs;
  T most = T(0);
  for (int j = 0; j < 4; ++j)
    for (int c = 0; c < 3; ++c) most = greater(most, greater(fabs(x_t0[j][c]), fabs(x_t1[j][c])));
  return T(0.5) * epsilon<T> * most + smallest_normal<T>;
}

}  // namespace weft
