#include "host/untangle/untangle.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "host/untangle/coarse_surfaces.hpp"
#include "host/untangle/correction.hpp"
#include "host/untangle/separate.hpp"
#include "host/untangle/spread.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

constexpr int patience = 12;      ///< rounds without progress, then something else is tried
constexpr int remedies_max = 10;  ///< tried in all, the first included
constexpr int settle_rounds = 40;
constexpr int smooth_sweeps = 3;       ///< a round
constexpr double rise_allowed = 1.01;  ///< of the contours' length in a round
constexpr int rings_at_first = 4;

constexpr Index coarse_enough = 2500;    ///< triangles of cloth that no coarser mesh is made for
constexpr Index coarsest_wanted = 2000;  ///< triangles of cloth, at least
constexpr Index coarsening = 4;          ///< triangles of which one is left
constexpr double coarse_share = 0.8;     ///< of the triangles, at most, for rounds there to pay
/// Of a coarse mesh's edges, between its surfaces once they are parted: those of the finer mesh,
/// which are curved between its vertices, then hardly meet.
constexpr double coarse_gap = 0.2;
constexpr double short_contour = 16;  ///< edges
constexpr int short_rounds = 32;      ///< that short contours get before a coarser mesh is tried

/// Whether rounds still lead anywhere.
class Progress {
 public:
  /// @param length [m] of contours   @param behind points on wrong sides, at most
  Progress(double length, std::size_t behind) : length_(length), behind_(behind) {}

  bool goes_on(double length, std::size_t behind) {
    const bool shorter = length < 0.99 * length_;
    const bool fewer = static_cast<double>(behind) < 0.99 * static_cast<double>(behind_);
    if (shorter) length_ = length;
    if (fewer) behind_ = behind;
    rounds_ = shorter || fewer ? 0 : rounds_ + 1;
    return rounds_ <= patience;
  }

 private:
  double length_;
  std::size_t behind_;
  int rounds_ = 0;
};

enum class Remedy {
  none,           ///< corrections alone
  carry_forward,  ///< regions go along their mean normals
  smooth,         ///< cloth around contours is smoothed
  carry_back,     ///< regions go against their mean normals
  shrink,         ///< contours get shorter, whatever they divide
  count,
};

/// Mean length of the edges of cloth that contours are on.
double edge_size(const IntersectingSurfaces& s, const SurfaceTopology& topology,
                 const Contours& c) {
  double sum = 0;
  double count = 0;
  const auto add = [&](Index t) {
    if (t >= s.cloth_triangle_count) return;
    for (const Index e : topology.triangle_edges[at(t)]) {
      const Edge& edge = topology.edges[at(e)];
      sum += length(s.points[at(edge.v[1])] - s.points[at(edge.v[0])]);
      ++count;
    }
  };
  for (const ContourArc& arc : c.arcs)
    for (const Index t : arc.triangle) add(t);
  for (const auto& [a, b] : c.touching) {
    add(a);
    add(b);
  }
  return count > 0 ? sum / count : 0;
}

/// All rounds on one mesh, after those on coarser ones.
class Untangling {
 public:
  /// @param awake [points] only intersections of these are looked for at first
  Untangling(IntersectingSurfaces& surfaces, const UntangleSettings& settings,
             std::vector<unsigned char> awake)
      : s_(surfaces),
        settings_(settings),
        topology_(surfaces.triangles, surfaces.points.size()),
        search_(surfaces, topology_),
        spreader_(surfaces, topology_),
        awake_(std::move(awake)) {}

  /// Ends with surfaces at least the gap apart, if there is room.
  UntangleReport run() {
    part();
    separate_moved(settings_.gap);
    return std::move(report_);
  }

 private:
  struct State {
    std::vector<Point> points;
    Contours contours;
  };

  /// Parts what intersects: after motion on a coarser mesh if this one is large and its contours
  /// are not all short, and from the start on this mesh alone if that fails. Of all attempts, the
  /// one with the shortest contours counts.
  void part() {
    const State start{s_.points, search_.find(awake_)};
    report_.contour_length.push_back(start.contours.length());
    edge_size_ = edge_size(s_, topology_, start.contours);
    State best = start;
    // Returns whether to try again without the coarser mesh.
    const auto attempt = [&](bool coarsely, int rounds_max) {
      std::fill(awake_.begin(), awake_.end(), static_cast<unsigned char>(0));
      s_.points = start.points;
      Contours contours = start.contours;
      remedy_ = Remedy::none;
      rings_ = rings_at_first;
      const bool parted = coarsely && part_coarsely(contours);
      go_round(contours, rounds_max);
      if (contours.empty() || contours.length() < best.contours.length())
        best = {s_.points, std::move(contours)};
      return parted;
    };
    bool alone = true;
    if (s_.cloth_triangle_count > coarse_enough && !best.contours.empty()) {
      if (all_short(best.contours)) attempt(false, std::min(short_rounds, settings_.rounds_max));
      if (!best.contours.empty()) alone = attempt(true, settings_.rounds_max);
    }
    if (alone && !best.contours.empty()) attempt(false, settings_.rounds_max);
    s_.points = std::move(best.points);
    report_.left = std::move(best.contours);
    if (report_.left.empty() && report_.contour_length.size() > 1) settle();
  }

  void separate_moved(double gap) {
    if (report_.left.empty() && report_.contour_length.size() > 1)
      separate(s_, topology_, search_, spreader_, awake_, gap);
  }

  /// All rounds of motion on this mesh, until no contour is left or none of the remedies helps any
  /// more. Ends where contours were shortest.
  void go_round(Contours& contours, int rounds_max) {
    Progress progress(contours.length(), s_.points.size());
    int remedies = 0;
    double least_length = contours.length();
    std::vector<Point> least_points = s_.points;
    for (int round = 0; round < rounds_max && !contours.empty(); ++round) {
      if (settings_.each_round) settings_.each_round();
      const std::size_t behind = move(contours);
      report_.contour_length.push_back(contours.length());
      if (contours.length() < least_length) {
        least_length = contours.length();
        least_points = s_.points;
      }
      if (progress.goes_on(contours.length(), behind)) continue;
      progress = Progress(contours.length(), s_.points.size());
      if (++remedies == remedies_max) break;
      if (remedy_ == Remedy::smooth) rings_ *= 2;
      remedy_ = static_cast<Remedy>(remedies % static_cast<int>(Remedy::count));
    }
    if (contours.empty()) return;
    s_.points = std::move(least_points);
    contours = search_.find(awake_);
  }

  /// Short contours often take few rounds, and a coarse mesh might not show which side they are on.
  bool all_short(const Contours& contours) const {
    std::vector<double> lengths(at(contours.count), 0);
    for (const ContourArc& arc : contours.arcs)
      lengths[at(contours.number[at(arc.piercing[0])])] += arc.length;
    return std::all_of(lengths.begin(), lengths.end(),
                       [&](double length) { return length <= short_contour * edge_size_; });
  }

  /// Parts a coarser mesh of the same cloth and lets this one follow, if nothing intersects there
  /// any more or its contours get shorter. A quarter of an edge is farther there, and stretch
  /// spreads in fewer sweeps.
  /// @return whether there were intersections there, of which none is left
  bool part_coarsely(Contours& contours) {
    CoarseSurfaces coarse(s_, std::max(coarsest_wanted, s_.cloth_triangle_count / coarsening));
    if (coarse.surfaces().cloth_triangle_count > coarse_share * s_.cloth_triangle_count)
      return false;
    wake(contours);
    Untangling on_coarse(coarse.surfaces(), settings_, coarse.marked(awake_));
    on_coarse.part();
    if (on_coarse.report_.contour_length.size() == 1) return false;
    on_coarse.separate_moved(coarse_gap * on_coarse.edge_size_);
    const bool parted = on_coarse.report_.left.empty();
    const std::vector<Point> before = s_.points;
    coarse.carry_over(s_.points);
    const std::vector<unsigned char> awake_before = awake_;
    for (std::size_t v = 0; v < before.size(); ++v)
      if (!(s_.points[v] == before[v])) awake_[v] = 1;
    Contours found = search_.find(awake_);
    if (parted || found.length() < contours.length()) {
      contours = std::move(found);
      report_.contour_length.push_back(contours.length());
    } else {
      s_.points = before;
      awake_ = awake_before;
    }
    return parted;
  }

  void wake(const Contours& contours) {
    const auto wake_triangle = [&](Index t) {
      for (const Index v : s_.triangles[at(t)].v) awake_[at(v)] = 1;
    };
    for (const Piercing& p : contours.piercings) {
      wake_triangle(p.face);
      for (const Index v : topology_.edges[at(p.edge)].v) awake_[at(v)] = 1;
    }
    for (const auto& [a, b] : contours.touching) {
      wake_triangle(a);
      wake_triangle(b);
    }
  }

  /// One round: corrects what is wrong about the contours, and finds them again. Motions that make
  /// contours longer, as they may where surfaces nearly coincide, are tried at half and at a
  /// quarter as well.
  /// @return how many points there were on wrong sides, and contours that divide nothing
  std::size_t move(Contours& contours) {
    wake(contours);
    const double step = edge_size(s_, topology_, contours) / 4;
    Corrections corrections =
        find_corrections(s_, topology_, contours, {step, std::min(settings_.gap, step), scope()});
    if (remedy_ == Remedy::carry_forward) carry(corrections, step);
    if (remedy_ == Remedy::carry_back) carry(corrections, -step);
    const std::vector<Point> motion = spreader_.motion(corrections, step);
    const std::vector<Point> before = s_.points;
    const double allowed = contours.length() > 0 ? rise_allowed * contours.length()
                                                 : std::numeric_limits<double>::max();
    std::vector<Point> best;
    Contours least;
    for (double share = 1; share > 0.2; share /= 2) {
      s_.points = before;
      follow(motion, share, contours);
      Contours found = search_.find(awake_);
      if (best.empty() || found.length() < least.length()) {
        best = s_.points;
        least = std::move(found);
      }
      if (least.length() <= allowed) break;
    }
    s_.points = std::move(best);
    std::size_t behind = at(contours.count) + contours.touching.size();
    for (const Region& region : corrections.regions) behind += region.points.size();
    contours = std::move(least);
    return behind;
  }

  Scope scope() const {
    if (remedy_ == Remedy::shrink) return Scope::shrink;
    return remedy_ == Remedy::smooth ? Scope::solids : Scope::all;
  }

  /// Moves points by a share of a motion, and lets stretched edges around them shrink.
  void follow(const std::vector<Point>& motion, double share, const Contours& contours) {
    std::vector<unsigned char> moved(s_.points.size(), 0);
    for (std::size_t v = 0; v < motion.size(); ++v) {
      if (motion[v] == Point{0, 0, 0}) continue;
      s_.points[v] += motion[v] * share;
      moved[v] = awake_[v] = 1;
    }
    if (remedy_ == Remedy::smooth) smooth(contours);
    relax(moved);
  }

  void relax(const std::vector<unsigned char>& moved) {
    const std::vector<Point> before = s_.points;
    spreader_.relax(moved, s_.points);
    for (std::size_t v = 0; v < before.size(); ++v)
      if (!(s_.points[v] == before[v])) awake_[v] = 1;
  }

  /// Lets cloth that was stretched on the way out shrink, and keeps the least stretched state that
  /// is free of contours. The present one is.
  void settle() {
    remedy_ = Remedy::none;
    std::vector<Point> best = s_.points;
    double best_stretch = spreader_.stretch(s_.points);
    for (int round = 0; round < settle_rounds && best_stretch > 0; ++round) {
      if (settings_.each_round) settings_.each_round();
      relax(awake_);
      Contours contours = search_.find(awake_);
      if (!contours.empty()) move(contours);
      if (!contours.empty()) continue;
      const double stretch = spreader_.stretch(s_.points);
      if (stretch >= best_stretch) continue;
      best_stretch = stretch;
      best = s_.points;
    }
    s_.points = best;
  }

  /// Wants every region to go by `way` [m] along its mean normal.
  void carry(Corrections& corrections, double way) const {
    std::vector<Point> normals(s_.points.size(), Point{0, 0, 0});
    for (const Tri& t : s_.triangles) {
      const Point& a = s_.points[at(t.v[0])];
      const Point n = cross(s_.points[at(t.v[1])] - a, s_.points[at(t.v[2])] - a);
      for (const Index v : t.v) normals[at(v)] += n;
    }
    for (std::size_t r = 0; r < corrections.regions.size(); ++r) {
      Point n{0, 0, 0};
      for (const Index v : corrections.regions[r].points) n += normals[at(v)];
      const double size = length(n);
      if (!(size > 0)) continue;
      for (const Index v : corrections.regions[r].points)
        corrections.list.push_back(
            {{v, 0, 0, 0, 0}, {1, 0, 0, 0, 0}, 1, n * (way / size), static_cast<Index>(r)});
    }
  }

  /// Draws points near contours towards the mean of their neighbours.
  void smooth(const Contours& contours) {
    std::vector<Index> near;
    std::vector<unsigned char> taken(s_.points.size(), 0);
    const auto take = [&](Index v) {
      if (taken[at(v)] != 0 || s_.inverse_mass[at(v)] == 0) return;
      taken[at(v)] = 1;
      near.push_back(v);
    };
    for (const Piercing& p : contours.piercings) {
      const Edge& e = topology_.edges[at(p.edge)];
      const Index of_edge = topology_.edge_triangles[at(topology_.edge_first[at(p.edge)])];
      if (std::max(of_edge, p.face) >= s_.cloth_triangle_count) continue;  // it is pushed out
      for (const Index v : e.v) take(v);
      for (const Index v : s_.triangles[at(p.face)].v) take(v);
    }
    std::size_t done = 0;
    for (int ring = 0; ring < rings_; ++ring)
      for (const std::size_t end = near.size(); done < end; ++done) {
        const auto v = at(near[done]);
        for (Index k = topology_.point_first[v]; k < topology_.point_first[v + 1]; ++k)
          take(topology_.neighbours[at(k)]);
      }
    std::vector<Point> to(near.size());
    for (int sweep = 0; sweep < smooth_sweeps; ++sweep) {
      for (std::size_t i = 0; i < near.size(); ++i) to[i] = smoothed(near[i]);
      for (std::size_t i = 0; i < near.size(); ++i) s_.points[at(near[i])] = to[i];
    }
    for (const Index v : near) awake_[at(v)] = 1;
  }

  /// Half way to the mean of a point's neighbours; of one on a border, to that of those on it.
  Point smoothed(Index v) const {
    Point sums[2] = {{0, 0, 0}, {0, 0, 0}};
    int counts[2] = {0, 0};
    for (Index k = topology_.point_first[at(v)]; k < topology_.point_first[at(v) + 1]; ++k) {
      const Index e = topology_.point_edges[at(k)];
      const int border = topology_.edge_first[at(e) + 1] - topology_.edge_first[at(e)] == 1;
      sums[border] += s_.points[at(topology_.neighbours[at(k)])];
      ++counts[border];
    }
    const int which = counts[1] > 0 ? 1 : 0;
    return (s_.points[at(v)] + sums[which] * (1.0 / counts[which])) * 0.5;
  }

  IntersectingSurfaces& s_;
  UntangleSettings settings_;
  SurfaceTopology topology_;
  ContourSearch search_;
  Spreader spreader_;
  std::vector<unsigned char> awake_;  ///< [points] that have moved, or are on contours
  Remedy remedy_ = Remedy::none;
  double edge_size_ = 0;        ///< [m] of contours at the start
  int rings_ = rings_at_first;  ///< around contours, that are smoothed
  UntangleReport report_;
};

}  // namespace

UntangleReport untangle(IntersectingSurfaces& surfaces, const UntangleSettings& settings) {
  std::vector<unsigned char> all(surfaces.points.size(), 1);
  return Untangling(surfaces, settings, std::move(all)).run();
}

}  // namespace weft
