#pragma once

#include <algorithm>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// A body that turns about a fixed axis, and what it has been given since it last answered.
struct BodyMotion {
  Vec3<double> origin;  ///< [m] of the axis
  Vec3<double> axis;    ///< unit
  double angle = 0;     ///< [rad] at its next tick
  double speed = 0;     ///< [rad/s] until then
  double impulse = 0;   ///< [N m s] about the axis, taken at that tick
};

/// Where every vertex was last looked at, and how it has gone on since: straight. Forces look only
/// at the vertices that they act on, so that each has a time of its own.
struct VertexMotion {
  std::vector<Vec3<double>> x;   ///< [vertices] [m] at time t
  std::vector<Vec3<double>> v;   ///< [vertices] [m/s] from then on
  std::vector<double> t;         ///< [vertices] [s]
  std::vector<double> inv_mass;  ///< [vertices] [1/kg] 0 where the position is prescribed
  std::vector<BodyMotion> bodies{};
  /// [vertices] the body that carries it where the position is prescribed, -1: none; empty: no body
  std::vector<Index> carrier{};

  std::size_t bytes() const {
    return (x.capacity() + v.capacity()) * sizeof(Vec3<double>) +
           (t.capacity() + inv_mass.capacity()) * sizeof(double) +
           bodies.capacity() * sizeof(BodyMotion) + carrier.capacity() * sizeof(Index);
  }
  Vec3<double> position(std::size_t i, double time) const { return x[i] + v[i] * (time - t[i]); }
  /// Moves a vertex on to `time`.
  void advance(std::size_t i, double time) {
    x[i] = position(i, time);
    t[i] = time;
  }
  /// What a force does to a vertex of infinite mass: it turns the body that carries it.
  /// @param impulse [N s]
  void push_carrier(std::size_t i, double time, const Vec3<double>& impulse) {
    if (carrier.empty() || carrier[i] < 0) return;
    BodyMotion& body = bodies[static_cast<std::size_t>(carrier[i])];
    body.impulse += dot(body.axis, cross(position(i, time) - body.origin, impulse));
  }
};

/// A point of a vertex's way through a window.
struct Breakpoint {
  double t;        ///< [s]
  Vec3<double> x;  ///< [m]
};

/// The way of one vertex through a window: straight from breakpoint to breakpoint, in increasing
/// time.
using Trajectory = Span<const Breakpoint>;

/// Number of the breakpoint that begins the piece which `time` lies in.
/// @pre at least two breakpoints, the first not after and the last not before `time`
inline std::size_t piece_at(const Trajectory& way, double time) {
  const Breakpoint* above = std::upper_bound(way.begin() + 1, way.end() - 1, time,
                                             [](double t, const Breakpoint& k) { return t < k.t; });
  return static_cast<std::size_t>(above - way.begin()) - 1;
}

/// Position on the piece that begins with breakpoint `k`. [m]
inline Vec3<double> position_on(const Trajectory& way, std::size_t k, double time) {
  const Breakpoint& a = way[k];
  const Breakpoint& b = way[k + 1];
  if (!(time < b.t)) return b.x;
  return a.x + (b.x - a.x) * ((time - a.t) / (b.t - a.t));
}

inline Vec3<double> position_at(const Trajectory& way, double time) {
  return position_on(way, piece_at(way, time), time);
}

}  // namespace weft
