#pragma once

#include <algorithm>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Where every vertex was last looked at, and how it has gone on since: straight. Forces look only
/// at the vertices that they act on, so that each has a time of its own.
struct VertexMotion {
  std::vector<Vec3<double>> x;   ///< [vertices] [m] at time t
  std::vector<Vec3<double>> v;   ///< [vertices] [m/s] from then on
  std::vector<double> t;         ///< [vertices] [s]
  std::vector<double> inv_mass;  ///< [vertices] [1/kg] 0 where the position is prescribed

  Vec3<double> position(std::size_t i, double time) const { return x[i] + v[i] * (time - t[i]); }
  /// Moves a vertex on to `time`.
  void advance(std::size_t i, double time) {
    x[i] = position(i, time);
    t[i] = time;
  }
};

/// A point of a vertex's way through a window.
struct Knot {
  double t;        ///< [s]
  Vec3<double> x;  ///< [m]
};

/// The way of one vertex through a window: straight from knot to knot, in increasing time.
using Trajectory = Span<const Knot>;

/// Number of the knot that begins the piece which `time` lies in.
/// @pre at least two knots, the first not after and the last not before `time`
inline std::size_t piece_at(const Trajectory& way, double time) {
  const Knot* above = std::upper_bound(way.begin() + 1, way.end() - 1, time,
                                       [](double t, const Knot& k) { return t < k.t; });
  return static_cast<std::size_t>(above - way.begin()) - 1;
}

/// Position on the piece that begins with knot `k`. [m]
inline Vec3<double> position_on(const Trajectory& way, std::size_t k, double time) {
  const Knot& a = way[k];
  const Knot& b = way[k + 1];
  if (!(time < b.t)) return b.x;
  return a.x + (b.x - a.x) * ((time - a.t) / (b.t - a.t));
}

inline Vec3<double> position_at(const Trajectory& way, double time) {
  return position_on(way, piece_at(way, time), time);
}

/// The ways of all vertices through one window.
class Histories {
 public:
  /// Begins anew.
  void reset(const VertexMotion& motion, double time) {
    knots_.resize(motion.x.size());
    for (std::size_t i = 0; i < knots_.size(); ++i) {
      knots_[i].clear();
      knots_[i].push_back({time, motion.position(i, time)});
    }
  }
  /// A vertex is about to change its velocity.
  void add(std::size_t i, double time, const Vec3<double>& x) {
    if (time > knots_[i].back().t) knots_[i].push_back({time, x});
  }
  /// Every way ends here.
  void finish(std::size_t i, double time, const Vec3<double>& x) { knots_[i].push_back({time, x}); }

  std::size_t size() const { return knots_.size(); }
  Trajectory operator[](std::size_t i) const { return {knots_[i].data(), knots_[i].size()}; }

 private:
  std::vector<std::vector<Knot>> knots_;
};

}  // namespace weft
