#include "host/adaptive/separate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "weft/elements/ccd.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

constexpr int rounds_max = 60;
constexpr int patience = 8;      ///< rounds without progress
constexpr int brake_rounds = 8;  ///< of continuous detection, a motion
constexpr double enough = 0.98;  ///< times the gap
// What no motion goes below. A share of the distance alone would let pairs that there is no room
// for come nearer round by round, until they touch but for rounding: of near ones nearly all of it
// stays, which leaves a quarter after all rounds.
constexpr double kept_share = 0.2;        ///< of a distance
constexpr double kept_share_near = 0.98;  ///< of a distance that is below near_share
constexpr double near_share = 0.1;        ///< of the gap

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

/// A vertex and a triangle's corners, or the ends of two edges.
struct Four {
  Index point[4];
  bool edges;
};

/// All rounds of one call.
class Separation {
 public:
  Separation(TangledSurfaces& surfaces, const SurfaceTopology& topology, ContourSearch& search,
             Spreader& spreader, std::vector<unsigned char>& awake, double gap)
      : s_(surfaces),
        topology_(topology),
        search_(search),
        spreader_(spreader),
        awake_(awake),
        gap_(gap),
        owner_(surfaces.points.size(), -1) {
    for (std::size_t t = s_.triangles.size(); t-- > 0;)
      for (const Index v : s_.triangles[t].v) owner_[at(v)] = static_cast<Index>(t);
  }

  void run() {
    double best = 0;
    int without_progress = 0;
    for (int round = 0; round < rounds_max; ++round) {
      double missing = 0;
      const Corrections corrections = too_close(missing);
      if (corrections.list.empty()) return;
      if (round == 0 || missing < 0.99 * best) {
        best = missing;
        without_progress = 0;
      } else if (++without_progress > patience) {
        return;
      }
      std::vector<Point> motion = spreader_.motion(corrections, gap_);
      brake(motion);
      for (std::size_t v = 0; v < motion.size(); ++v) s_.points[v] += motion[v];
    }
  }

 private:
  /// Calls visit(Four) for each pair of features without a common vertex whose triangles' boxes,
  /// larger by `pad`, overlap.
  template <class Visit>
  void visit_fours(double pad, const Visit& visit) {
    const auto look = [&](Index t, Index face) {
      const Tri& f = s_.triangles[at(face)];
      for (const Index v : s_.triangles[at(t)].v)
        if (owner_[at(v)] == t && v != f.v[0] && v != f.v[1] && v != f.v[2])
          visit(Four{{v, f.v[0], f.v[1], f.v[2]}, false});
    };
    search_.visit_near(pad, awake_, [&](Index a, Index b) {
      look(a, b);
      look(b, a);
      for (const Index e : topology_.triangle_edges[at(a)]) {
        if (topology_.edge_triangles[at(topology_.edge_first[at(e)])] != a) continue;
        for (const Index f : topology_.triangle_edges[at(b)]) {
          if (topology_.edge_triangles[at(topology_.edge_first[at(f)])] != b) continue;
          const Edge& p = topology_.edges[at(e)];
          const Edge& q = topology_.edges[at(f)];
          if (p.v[0] != q.v[0] && p.v[0] != q.v[1] && p.v[1] != q.v[0] && p.v[1] != q.v[1])
            visit(Four{{p.v[0], p.v[1], q.v[0], q.v[1]}, true});
        }
      }
    });
  }

  bool joined(Index v, Index w) const {
    const auto first = topology_.neighbours.begin();
    return std::find(first + topology_.point_first[at(v)], first + topology_.point_first[at(v) + 1],
                     w) != first + topology_.point_first[at(v) + 1];
  }

  /// Whether an edge joins the two features: they are close on any shape then.
  bool beside(const Four& f) const {
    const int split = f.edges ? 2 : 1;
    for (int i = 0; i < split; ++i)
      for (int j = split; j < 4; ++j)
        if (joined(f.point[i], f.point[j])) return true;
    return false;
  }

  std::array<Point, 4> places(const Four& f) const {
    std::array<Point, 4> x;
    for (std::size_t j = 0; j < 4; ++j) x[j] = s_.points[at(f.point[j])];
    return x;
  }

  static Proximity<double> proximity(const Four& f, const std::array<Point, 4>& x) {
    return f.edges ? edge_edge(x.data()) : vertex_triangle(x.data());
  }

  /// @param missing [m] sum of what pairs are too close by
  Corrections too_close(double& missing) {
    Corrections found;
    visit_fours(gap_ / 2, [&](const Four& f) {
      const std::array<Point, 4> x = places(f);
      if (f.edges ? edge_edge_farther(x.data(), gap_) : vertex_triangle_farther(x.data(), gap_))
        return;
      const Proximity<double> p = proximity(f, x);
      const double distance = std::sqrt(p.distance_sq);
      if (distance >= enough * gap_ || !(distance > 0) || beside(f)) return;
      double mobility = 0;
      for (int j = 0; j < 4; ++j) mobility += std::fabs(p.w[j]) * s_.inverse_mass[at(f.point[j])];
      if (!(mobility > 0)) return;
      missing += gap_ - distance;
      found.list.push_back({{f.point[0], f.point[1], f.point[2], f.point[3], 0},
                            {p.w[0], p.w[1], p.w[2], p.w[3], 0},
                            4,
                            p.difference * ((gap_ - distance) / distance),
                            -1});
    });
    return found;
  }

  double kept_of(double distance) const {
    return std::max(kept_share * distance, std::min(near_share * gap_, kept_share_near * distance));
  }

  /// Shortens motions until continuous detection finds no pair that comes closer than a share of
  /// its distance.
  void brake(std::vector<Point>& motion) {
    double farthest = 0;
    for (std::size_t v = 0; v < motion.size(); ++v) {
      if (!(motion[v] == Point{0, 0, 0})) awake_[v] = 1;
      farthest = std::max(farthest, length(motion[v]));
    }
    std::vector<double> share(motion.size(), 1);
    for (int round = 0; round < brake_rounds; ++round) {
      std::fill(share.begin(), share.end(), 1.0);
      bool any = false;
      visit_fours(farthest, [&](const Four& f) {
        const std::array<Point, 4> start = places(f);
        std::array<Point, 4> end;
        for (std::size_t j = 0; j < 4; ++j) end[j] = start[j] + motion[at(f.point[j])];
        const double kept = kept_of(std::sqrt(proximity(f, start).distance_sq));
        const Impact impact = f.edges ? ccd_edge_edge(start.data(), end.data(), kept)
                                      : ccd_vertex_triangle(start.data(), end.data(), kept);
        if (!impact.hit) return;
        any = true;
        const double allowed = round + 1 < brake_rounds / 2 ? 0.9 * impact.toi : 0;
        for (const Index v : f.point) share[at(v)] = std::min(share[at(v)], allowed);
      });
      if (!any) return;
      for (std::size_t v = 0; v < motion.size(); ++v) motion[v] *= share[v];
    }
    std::fill(motion.begin(), motion.end(), Point{0, 0, 0});
  }

  TangledSurfaces& s_;
  const SurfaceTopology& topology_;
  ContourSearch& search_;
  Spreader& spreader_;
  std::vector<unsigned char>& awake_;
  double gap_;
  std::vector<Index> owner_;  ///< [points] the first triangle with that corner
};

}  // namespace

void separate(TangledSurfaces& surfaces, const SurfaceTopology& topology, ContourSearch& search,
              Spreader& spreader, std::vector<unsigned char>& awake, double gap) {
  Separation(surfaces, topology, search, spreader, awake, gap).run();
}

}  // namespace weft
