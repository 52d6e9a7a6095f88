#include "host/asynchronous/narrow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "weft/elements/ccd.hpp"

namespace weft {
namespace {

/// Slabs have to be thicker than the distance by this share of it, so that where spans meet in a
/// rounded time both sides cover it.
constexpr double span_slab_margin = 1e-6;

struct Query {
  const PrimitivePair& pair;
  const Trajectory* trajectories;
  double distance;
  double needed;  ///< [m] thickness of slabs
  NarrowCounts& counts;
  int slabs_left;
  bool counted_failsafe;
};

/// Continuous detection on the pieces of [t0, t1], between any two breakpoints of any corner.
bool pieces_come_within(Query& q, double t0, double t1) {
  if (!q.counted_failsafe) ++q.counts.failsafe;
  q.counted_failsafe = true;
  std::size_t piece[4];
  Vec3<double> x0[4], x1[4];
  for (int c = 0; c < 4; ++c) {
    piece[c] = piece_at(q.trajectories[c], t0);
    x0[c] = position_on(q.trajectories[c], piece[c], t0);
  }
  for (double t = t0; t < t1;) {
    double end = t1;
    for (int c = 0; c < 4; ++c) end = std::min(end, q.trajectories[c][piece[c] + 1].t);
    for (int c = 0; c < 4; ++c) x1[c] = position_on(q.trajectories[c], piece[c], end);
    ++q.counts.ccd;
    const Impact<double> impact = q.pair.of_edges() ? ccd_edge_edge(x0, x1, q.distance)
                                                    : ccd_vertex_triangle(x0, x1, q.distance);
    if (impact.hit) return true;
    for (int c = 0; c < 4; ++c) {
      x0[c] = x1[c];
      while (piece[c] + 2 < q.trajectories[c].size() && !(end < q.trajectories[c][piece[c] + 1].t))
        ++piece[c];
    }
    t = end;
  }
  return false;
}

/// A plane that moves: points with n . x = offset + speed (t - start).
struct MovingPlane {
  Vec3<double> n;
  double offset, speed, start;

  /// How far beyond the plane, on the side that `side` = +-1 of n points to.
  double beyond(const Breakpoint& k, double side) const {
    return side * (dot(n, k.x) - offset - speed * (k.t - start));
  }
};

/// Narrows [from, to] about `mid` to where a way stays beyond the plane.
void stay_beyond(const Trajectory& way, const MovingPlane& plane, double side, double mid,
                 double& from, double& to) {
  const std::size_t piece = piece_at(way, mid);
  const Breakpoint here{mid, position_on(way, piece, mid)};
  const double at_mid = plane.beyond(here, side);
  Breakpoint last = here;
  double last_beyond = at_mid;
  for (std::size_t k = piece + 1; k < way.size() && last.t < to; ++k) {
    const double beyond = plane.beyond(way[k], side);
    if (!(beyond >= 0)) {
      to = std::min(to, last.t + (way[k].t - last.t) * (last_beyond / (last_beyond - beyond)));
      break;
    }
    last = way[k];
    last_beyond = beyond;
  }
  last = here;
  last_beyond = at_mid;
  for (std::size_t k = piece + 1; k-- > 0 && last.t > from;) {
    const double beyond = plane.beyond(way[k], side);
    if (!(beyond >= 0)) {
      from = std::max(from, last.t - (last.t - way[k].t) * (last_beyond / (last_beyond - beyond)));
      break;
    }
    last = way[k];
    last_beyond = beyond;
  }
}

bool span_comes_within(Query& q, double t0, double t1) {
  // The later part goes on in the loop, the earlier one in the recursion, which is bounded by the
  // number of slabs.
  while (t0 < t1) {
    if (t1 - t0 < slab_span_min || q.slabs_left <= 0) return pieces_come_within(q, t0, t1);
    --q.slabs_left;
    ++q.counts.slabs;
    const double mid = t0 + (t1 - t0) / 2;
    Vec3<double> x[4];
    for (int c = 0; c < 4; ++c) x[c] = position_at(q.trajectories[c], mid);
    const Proximity<double> p = q.pair.closest(x);
    if (!(p.distance_sq > q.distance * q.distance)) return true;
    const double d = std::sqrt(p.distance_sq);
    MovingPlane plane{p.difference * (1 / d), 0, 0, mid};
    const int first_count = q.pair.first_count();
    double first = std::numeric_limits<double>::infinity();
    double second = -first;
    for (int c = 0; c < 4; ++c) {
      const double along = dot(plane.n, x[c]);
      if (c < first_count)
        first = std::min(first, along);
      else
        second = std::max(second, along);
      plane.speed +=
          dot(plane.n, position_at(q.trajectories[c], t1) - position_at(q.trajectories[c], t0));
    }
    plane.speed /= 4 * (t1 - t0);
    const double slack = (first - second - q.needed) / 2;
    if (!(slack > 0)) return pieces_come_within(q, t0, t1);
    double from = t0;
    double to = t1;
    for (int c = 0; c < 4; ++c) {
      plane.offset = c < first_count ? first - slack : second + slack;
      stay_beyond(q.trajectories[c], plane, c < first_count ? 1 : -1, mid, from, to);
    }
    if (from > t0 && span_comes_within(q, t0, from)) return true;
    if (!(to < t1)) return false;
    t0 = to;
  }
  return false;
}

}  // namespace

bool comes_within(const PrimitivePair& pair, const Trajectory trajectories[4], double distance,
                  bool slabs, double rounding, NarrowCounts& counts) {
  ++counts.calls;
  const double t0 = trajectories[0][0].t;
  const double t1 = trajectories[0][trajectories[0].size() - 1].t;
  Query q{pair,   trajectories, distance, distance * (1 + span_slab_margin) + rounding,
          counts, slabs_max,    false};
  return slabs ? span_comes_within(q, t0, t1) : pieces_come_within(q, t0, t1);
}

}  // namespace weft
