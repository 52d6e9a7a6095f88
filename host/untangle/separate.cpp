#include "host/untangle/separate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "weft/core/at.hpp"
#include "weft/elements/ccd.hpp"
#include "weft/elements/contact.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

constexpr int separation_rounds_max = 60;
constexpr int separation_patience = 4;       ///< rounds without progress
constexpr double separation_progress = 0.9;  ///< of what was missing
constexpr int brake_rounds = 8;              ///< of continuous detection, a motion
constexpr double enough = 0.98;              ///< times the gap
// What no motion goes below. A share of the distance alone would let pairs that there is no room
// for come nearer round by round, until they touch but for rounding: of near ones nearly all of it
// stays, which leaves a quarter after all rounds.
constexpr double kept_share = 0.2;        ///< of a distance
constexpr double kept_share_near = 0.98;  ///< of a distance that is below near_share
constexpr double near_share = 0.1;        ///< of the gap
/// Compression that counts, at most: layers of a sheet that are farther apart along it than a few
/// gaps are no neighbours, however it is crushed beside them.
constexpr double compression_least = 0.25;

/// A vertex and a triangle's corners, or the ends of two edges.
struct Four {
  Index point[4];
  bool edges;
};

/// All rounds of one call.
class Separation {
 public:
  Separation(IntersectingSurfaces& surfaces, const SurfaceTopology& topology, ContourSearch& search,
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
    for (int round = 0; round < separation_rounds_max; ++round) {
      double missing = 0;
      const Corrections corrections = too_close(missing);
      if (corrections.list.empty()) return;
      if (round == 0 || missing < separation_progress * best) {
        best = missing;
        without_progress = 0;
      } else if (++without_progress > separation_patience) {
        return;
      }
      std::vector<Point> motion = spreader_.motion(corrections, gap_);
      brake(motion);
      for (std::size_t v = 0; v < motion.size(); ++v) s_.points[v] += motion[v];
    }
  }

 private:
  /// Calls visit(Four) for each pair of features without a common vertex of which a triangle is
  /// awake, and whose triangles' boxes, larger by `pads` (one for all, or [triangles]), overlap.
  template <class Pads, class Visit>
  void visit_fours(const Pads& pads, const std::vector<unsigned char>& awake, const Visit& visit) {
    const auto look = [&](Index t, Index face) {
      const Tri& f = s_.triangles[at(face)];
      for (const Index v : s_.triangles[at(t)].v)
        if (owner_[at(v)] == t && v != f.v[0] && v != f.v[1] && v != f.v[2])
          visit(Four{{v, f.v[0], f.v[1], f.v[2]}, false});
    };
    search_.visit_in_pattern(pads, awake, [&](Index a, Index b) {
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

  /// How close a pair may come. Neighbours on one cloth may be closer than the gap where they are
  /// so at rest, and by as much as it is compressed there: that is for elasticity to undo, and to
  /// part them would be to stretch it.
  double gap_of(const Four& f) const {
    std::array<Point, 4> rest;
    double least = 1;
    for (std::size_t j = 0; j < 4; ++j) {
      const auto v = at(f.point[j]);
      if (v >= s_.rest.points.size() || s_.rest.cloth[v] != s_.rest.cloth[at(f.point[0])])
        return gap_;
      rest[j] = {s_.rest.points[v][0], s_.rest.points[v][1], 0};
      least = std::min(least, s_.rest.compression[v]);
    }
    const double distance = std::sqrt(proximity(f, rest).distance_sq);
    return std::min(gap_, rest_share * std::max(least, compression_least) * distance);
  }

  /// @param missing [m] sum of what pairs are too close by
  Corrections too_close(double& missing) {
    Corrections found;
    visit_fours(gap_ / 2, awake_, [&](const Four& f) {
      const std::array<Point, 4> x = places(f);
      if (f.edges ? edge_edge_farther(x.data(), gap_) : vertex_triangle_farther(x.data(), gap_))
        return;
      const Proximity<double> p = proximity(f, x);
      const double distance = std::sqrt(p.distance_sq);
      if (!(distance > 0) || beside(f)) return;
      const double gap = gap_of(f);
      if (distance >= enough * gap) return;
      double mobility = 0;
      for (int j = 0; j < 4; ++j) mobility += std::fabs(p.w[j]) * s_.inverse_mass[at(f.point[j])];
      if (!(mobility > 0)) return;
      missing += gap - distance;
      found.list.push_back({{f.point[0], f.point[1], f.point[2], f.point[3], 0},
                            {p.w[0], p.w[1], p.w[2], p.w[3], 0},
                            4,
                            p.difference * ((gap - distance) / distance),
                            -1});
    });
    return found;
  }

  double kept_of(double distance) const {
    return std::max(kept_share * distance, std::min(near_share * gap_, kept_share_near * distance));
  }

  /// From so far on features keep their share of the distance whatever they do on a motion of
  /// which no point goes farther than `way`, both together: kept_of(d) <= d - way for each d that
  /// is not below it.
  double out_of_reach(double way) const { return way / (1 - kept_share) + near_share * gap_; }

  /// [triangles] By how much boxes have to be larger for those of pairs within reach to overlap.
  std::vector<double> reaches(const std::vector<Point>& motion) const {
    std::vector<double> pads;
    for (const Tri& t : s_.triangles) {
      double way = 0;
      for (const Index v : t.v) way = std::max(way, length(motion[at(v)]));
      pads.push_back(out_of_reach(way));
    }
    return pads;
  }

  /// Continuous detection of a pair that is to keep a share of its distance.
  Impact<double> impact_of(const Four& f, const std::vector<Point>& motion) const {
    const std::array<Point, 4> start = places(f);
    double way[2] = {0, 0};
    for (int j = 0; j < 4; ++j) {
      double& of_feature = way[j < (f.edges ? 2 : 1) ? 0 : 1];
      of_feature = std::max(of_feature, length(motion[at(f.point[j])]));
    }
    if (way[0] + way[1] == 0) return {};
    const double reach = out_of_reach(way[0] + way[1]);
    if (f.edges ? edge_edge_farther(start.data(), reach)
                : vertex_triangle_farther(start.data(), reach))
      return {};
    std::array<Point, 4> end;
    for (std::size_t j = 0; j < 4; ++j) end[j] = start[j] + motion[at(f.point[j])];
    const double kept = kept_of(std::sqrt(proximity(f, start).distance_sq));
    return f.edges ? ccd_edge_edge(start.data(), end.data(), kept)
                   : ccd_vertex_triangle(start.data(), end.data(), kept);
  }

  /// Shortens motions until continuous detection finds no pair that comes closer than a share of
  /// its distance.
  void brake(std::vector<Point>& motion) {
    std::vector<unsigned char> changed(motion.size(), 0);
    for (std::size_t v = 0; v < motion.size(); ++v)
      if (!(motion[v] == Point{0, 0, 0})) awake_[v] = changed[v] = 1;
    std::vector<double> share(motion.size(), 1);
    for (int round = 0; round < brake_rounds; ++round) {
      std::fill(share.begin(), share.end(), 1.0);
      bool any = false;
      visit_fours(reaches(motion), changed, [&](const Four& f) {
        const Impact<double> impact = impact_of(f, motion);
        if (!impact.hit) return;
        any = true;
        const double allowed = round + 1 < brake_rounds / 2 ? 0.9 * impact.toi : 0;
        for (const Index v : f.point) share[at(v)] = std::min(share[at(v)], allowed);
      });
      if (!any) return;
      // Pairs of which nothing is shortened pass again.
      for (std::size_t v = 0; v < motion.size(); ++v) {
        changed[v] = share[v] < 1;
        motion[v] *= share[v];
      }
    }
    std::fill(motion.begin(), motion.end(), Point{0, 0, 0});
  }

  IntersectingSurfaces& s_;
  const SurfaceTopology& topology_;
  ContourSearch& search_;
  Spreader& spreader_;
  std::vector<unsigned char>& awake_;
  double gap_;
  std::vector<Index> owner_;  ///< [points] the first triangle with that corner
};

}  // namespace

void separate(IntersectingSurfaces& surfaces, const SurfaceTopology& topology,
              ContourSearch& search, Spreader& spreader, std::vector<unsigned char>& awake,
              double gap) {
  Separation(surfaces, topology, search, spreader, awake, gap).run();
}

}  // namespace weft
