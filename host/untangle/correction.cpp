#include "host/untangle/correction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "host/geometry/plane_side.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

/// Longest ways that are closed around the ends of a contour: a share of its length and some steps.
constexpr double wall_share = 1;
constexpr double wall_steps = 16;

/// Unit vector, or zero.
Point unit(const Point& x) {
  const double size = length(x);
  return size > 0 ? x * (1 / size) : Point{0, 0, 0};
}

/// For each piercing which of the two sheets that make its contour its edge belongs to, 0 or 1; -1
/// where the sheets cannot be told apart.
std::vector<int> tell_sheets_apart(const Contours& c) {
  std::vector<std::vector<const ContourArc*>> arcs(c.piercings.size());
  for (const ContourArc& arc : c.arcs) {
    if (arc.piercing[1] < 0) continue;
    for (const Index k : arc.piercing) arcs[at(k)].push_back(&arc);
  }
  std::vector<int> sheet(c.piercings.size(), -1);
  std::vector<unsigned char> unclear(static_cast<std::size_t>(c.count), 0);
  std::vector<Index> queue;
  for (std::size_t first = 0; first < sheet.size(); ++first) {
    if (sheet[first] >= 0) continue;
    sheet[first] = 0;
    queue.assign(1, static_cast<Index>(first));
    while (!queue.empty()) {
      const Index k = queue.back();
      queue.pop_back();
      for (const ContourArc* arc : arcs[at(k)]) {
        const Index other = arc->piercing[arc->piercing[0] == k ? 1 : 0];
        const bool same = c.piercings[at(other)].face == c.piercings[at(k)].face;
        const int wanted = same ? sheet[at(k)] : 1 - sheet[at(k)];
        if (sheet[at(other)] < 0) {
          sheet[at(other)] = wanted;
          queue.push_back(other);
        } else if (sheet[at(other)] != wanted) {
          unclear[at(c.number[at(k)])] = 1;
        }
      }
    }
  }
  for (std::size_t k = 0; k < sheet.size(); ++k)
    if (unclear[at(c.number[k])] != 0) sheet[k] = -1;
  return sheet;
}

/// One round of find_corrections().
class Finder {
 public:
  Finder(const IntersectingSurfaces& surfaces, const SurfaceTopology& topology,
         const Contours& contours, const CorrectionSettings& settings)
      : s_(surfaces),
        topology_(topology),
        c_(contours),
        settings_(settings),
        sheet_(tell_sheets_apart(contours)),
        crossings_(topology.edges.size(), 0),
        reached_{std::vector<Index>(surfaces.points.size(), -1),
                 std::vector<Index>(surfaces.points.size(), -1)},
        half_length_(contours.piercings.size(), 0) {
    for (const ContourArc& arc : contours.arcs)
      for (const Index k : arc.piercing)
        if (k >= 0) half_length_[at(k)] += arc.length;
  }

  Corrections find() {
    const std::vector<Point> pull = contour_pull(s_, c_);
    std::map<Index, std::vector<Index>> solids;
    std::vector<std::vector<Index>> contours(at(c_.count));
    for (std::size_t k = 0; k < c_.piercings.size(); ++k) {
      const Index solid = solid_of(static_cast<Index>(k));
      if (solid >= 0 && settings_.scope != Scope::shrink)
        solids[solid].push_back(static_cast<Index>(k));
      else
        contours[at(c_.number[k])].push_back(static_cast<Index>(k));
    }
    for (const auto& [solid, members] : solids) leave_solid(members);
    region_ = -1;
    for (const std::vector<Index>& members : contours) {
      if (members.empty() || settings_.scope == Scope::solids) continue;
      if (settings_.scope == Scope::shrink ||
          (!send_back(members, false) && !send_back(members, true)))
        for (const Index k : members) shrink(k, pull[at(k)]);
    }
    if (settings_.scope != Scope::solids)
      for (const auto& [a, b] : c_.touching) part_touching(a, b);
    return std::move(out_);
  }

 private:
  Index mesh_of_edge(Index e) const {
    return s_.mesh[at(topology_.edge_triangles[at(topology_.edge_first[at(e)])])];
  }

  /// The closed obstacle that a piercing is on, or -1.
  Index solid_of(Index k) const {
    const Piercing& p = c_.piercings[at(k)];
    const Index face_mesh = s_.mesh[at(p.face)];
    if (s_.solid[at(face_mesh)] != 0) return face_mesh;
    const Index edge_mesh = mesh_of_edge(p.edge);
    return s_.solid[at(edge_mesh)] != 0 ? edge_mesh : -1;
  }

  Point face_normal(Index t) const {
    const Tri& tri = s_.triangles[at(t)];
    const Point& a = s_.points[at(tri.v[0])];
    return cross(s_.points[at(tri.v[1])] - a, s_.points[at(tri.v[2])] - a);
  }

  Point edge_normal(Index e) const {
    Point n{0, 0, 0};
    for (Index i = topology_.edge_first[at(e)]; i < topology_.edge_first[at(e) + 1]; ++i)
      n += unit(face_normal(topology_.edge_triangles[at(i)]));
    return unit(n);
  }

  /// 1 where a point is in front of a triangle, -1 behind.
  int side(Index face, Index point) const {
    const Tri& t = s_.triangles[at(face)];
    return -plane_side(s_.points[at(t.v[0])], s_.points[at(t.v[1])], s_.points[at(t.v[2])],
                       s_.points[at(point)]);
  }

  /// Ends of the crossed edges of one sheet that lie on one side of the other.
  std::vector<Index> seeds(const std::vector<Index>& members, int sheet, int wanted_side) const {
    std::vector<Index> found;
    for (const Index k : members) {
      const Piercing& p = c_.piercings[at(k)];
      if (sheet_of(k) != sheet || crossings_[at(p.edge)] % 2 == 0) continue;
      const Edge& e = topology_.edges[at(p.edge)];
      for (const Index v : e.v)
        if (side(p.face, v) == wanted_side) found.push_back(v);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  /// For solids the cloth is sheet 0.
  int sheet_of(Index k) const { return by_solid_ ? solid_sheet(k) : sheet_[at(k)]; }
  int solid_sheet(Index k) const {
    return s_.solid[at(s_.mesh[at(c_.piercings[at(k)].face)])] != 0 ? 0 : 1;
  }

  void count_crossings(const std::vector<Index>& members, int change) {
    for (const Index k : members) crossings_[at(c_.piercings[at(k)].edge)] += change;
  }

  /// Floods one point's surroundings.
  void flood_from(Index v, Index mark, std::size_t which, std::vector<Index>& queue) {
    for (Index i = topology_.point_first[at(v)]; i < topology_.point_first[at(v) + 1]; ++i) {
      const Index w = topology_.neighbours[at(i)];
      if (reached_[which][at(w)] >= mark) continue;
      if (crossings_[at(topology_.point_edges[at(i)])] % 2 != 0) continue;
      reached_[which][at(w)] = mark;
      queue.push_back(w);
    }
  }

  /// Closes the ways around the ends of a contour that a sheet goes beyond: from each such end to
  /// the nearest border, if they are short next to the contour.
  void extend(const std::vector<Index>& members, int sheet) {
    walls_.clear();
    double allowed = wall_steps * settings_.step;
    for (const Index k : members) allowed += wall_share / 2 * half_length_[at(k)];
    for (const Index k : members) {
      const Piercing& p = c_.piercings[at(k)];
      // Where a border of the other sheet comes through, the contour ends in the middle of this
      // one.
      if (sheet_[at(k)] == sheet || !on_border(p.edge)) continue;
      allowed -= wall_from(p, allowed);
    }
  }

  bool on_border(Index e) const {
    return topology_.edge_first[at(e) + 1] - topology_.edge_first[at(e)] == 1;
  }

  /// Makes a wall of the shortest way along edges from the triangle around the end of a contour to
  /// a border.
  /// @return [m] its length, or more than `allowed` if there is none
  double wall_from(const Piercing& end, double allowed) {
    std::map<Index, std::pair<double, Index>> best;  // length, and where from
    std::set<std::pair<double, Index>> queue;
    for (const Index v : s_.triangles[at(end.face)].v) {
      bool crossed = false;
      for (Index i = topology_.point_first[at(v)]; i < topology_.point_first[at(v) + 1]; ++i)
        crossed = crossed || (crossings_[at(topology_.point_edges[at(i)])] % 2 != 0 &&
                              in_triangle(topology_.neighbours[at(i)], end.face));
      if (crossed) continue;  // an end of the last edge that is crossed, which belongs to a side
      best[v] = {length(s_.points[at(v)] - end.point), -1};
      queue.insert({best[v].first, v});
    }
    while (!queue.empty()) {
      const auto [far, v] = *queue.begin();
      queue.erase(queue.begin());
      if (far > allowed) break;
      bool border = false;
      for (Index i = topology_.point_first[at(v)]; i < topology_.point_first[at(v) + 1]; ++i) {
        const Index e = topology_.point_edges[at(i)];
        const Index w = topology_.neighbours[at(i)];
        border = border || on_border(e);
        if (crossings_[at(e)] % 2 != 0) continue;
        const double there = far + length(s_.points[at(w)] - s_.points[at(v)]);
        const auto known = best.find(w);
        if (known != best.end() && known->second.first <= there) continue;
        if (known != best.end()) queue.erase({known->second.first, w});
        best[w] = {there, v};
        queue.insert({there, w});
      }
      if (!border) continue;
      for (Index u = v; u >= 0; u = best[u].second) walls_.push_back(u);
      return far;
    }
    return 2 * allowed + 1;
  }

  bool in_triangle(Index v, Index t) const {
    const Tri& tri = s_.triangles[at(t)];
    return tri.v[0] == v || tri.v[1] == v || tri.v[2] == v;
  }

  /// Floods from both sides of a contour, point by point in turns, until one side is full.
  /// @return which side is the smaller one, and its points; -1 where the contour divides nothing
  int smaller_side(const std::array<std::vector<Index>, 2>& from, std::vector<Index>& points) {
    if (from[0].empty() || from[1].empty()) return -1;
    const Index mark = ++marks_;
    std::array<std::vector<Index>, 2> queue = from;
    std::array<std::size_t, 2> done{0, 0};
    for (std::size_t which = 0; which < 2; ++which)
      for (const Index v : from[which]) reached_[which][at(v)] = mark;
    const Index wall = ++marks_;  // counts as reached, but by neither side
    for (const Index v : walls_)
      for (std::size_t which = 0; which < 2; ++which)
        if (reached_[which][at(v)] != mark) reached_[which][at(v)] = wall;
    for (;;)
      for (std::size_t which = 0; which < 2; ++which) {
        if (done[which] == queue[which].size()) {
          points = std::move(queue[which]);
          return static_cast<int>(which);
        }
        const Index v = queue[which][done[which]++];
        if (reached_[1 - which][at(v)] == mark) return -1;
        flood_from(v, mark, which, queue[which]);
      }
  }

  bool holds(const std::vector<Index>& points) const {
    return std::any_of(points.begin(), points.end(),
                       [&](Index v) { return s_.inverse_mass[at(v)] == 0; });
  }

  /// Everything of the cloths that is inside an obstacle has to leave it.
  void leave_solid(const std::vector<Index>& members) {
    by_solid_ = true;
    count_crossings(members, 1);
    const std::vector<Index> outside = seeds(members, 0, 1);
    Region region{seeds(members, 0, -1), false};
    const Index mark = ++marks_;
    for (const Index v : region.points) reached_[0][at(v)] = mark;
    const std::vector<Index> inside = region.points;
    for (std::size_t i = 0; i < region.points.size(); ++i)
      flood_from(region.points[i], mark, 0, region.points);
    // Where a contour only grazes, inside and outside may hang together: no more is certain then.
    if (std::any_of(outside.begin(), outside.end(),
                    [&](Index v) { return reached_[0][at(v)] == mark; }))
      region.points = inside;
    region.held = holds(region.points);
    region_ = static_cast<Index>(out_.regions.size());
    out_.regions.push_back(std::move(region));
    for (const Index k : members) push(k, 0, 1);
    count_crossings(members, -1);
    by_solid_ = false;
  }

  /// Sends the smallest part that the contour cuts off back through the other sheet.
  /// @return false where the contour divides nothing
  bool send_back(const std::vector<Index>& members, bool extended) {
    if (sheet_[at(members.front())] < 0) return false;
    count_crossings(members, 1);
    Region best;
    int best_sheet = -1;
    int best_side = 0;
    for (int sheet = 0; sheet < 2; ++sheet) {
      Region region;
      walls_.clear();
      if (extended) extend(members, sheet);
      const int which =
          smaller_side({seeds(members, sheet, 1), seeds(members, sheet, -1)}, region.points);
      if (which < 0) continue;
      const bool obstacle = !movable(members, sheet);
      region.held = !obstacle && holds(region.points);
      if (best_sheet >= 0 && region.held && !best.held) continue;
      if (best_sheet < 0 || (best.held && !region.held) ||
          region.points.size() < best.points.size()) {
        best = std::move(region);
        best_sheet = sheet;
        best_side = which == 0 ? 1 : -1;
      }
    }
    if (best_sheet >= 0) {
      region_ = static_cast<Index>(out_.regions.size());
      out_.regions.push_back(std::move(best));
      for (const Index k : members) push(k, best_sheet, -best_side);
      region_ = -1;
    }
    count_crossings(members, -1);
    return best_sheet >= 0;
  }

  /// Whether the surface that is a contour's sheet is one of cloth.
  bool movable(const std::vector<Index>& members, int sheet) const {
    const Piercing& p = c_.piercings[at(members.front())];
    const Index triangle = sheet_[at(members.front())] == sheet
                               ? topology_.edge_triangles[at(topology_.edge_first[at(p.edge)])]
                               : p.face;
    return triangle < s_.cloth_triangle_count;
  }

  /// Wants `sheet` to go to one side of the other at one piercing.
  void push(Index k, int sheet, int good_side) {
    const Piercing& p = c_.piercings[at(k)];
    const Edge& e = topology_.edges[at(p.edge)];
    if (sheet_of(k) != sheet) {  // the face goes, along the normals of the surface with the edge
      const double way = -(settings_.step + settings_.margin) * good_side;
      add(p, e, edge_normal(p.edge) * way);
      return;
    }
    const Point n = unit(face_normal(p.face)) * good_side;
    if (crossings_[at(p.edge)] % 2 == 0) {  // both ends are right, what is between them is not
      add(p, e, n * (settings_.step + settings_.margin));
      return;
    }
    const Index wrong = side(p.face, e.v[0]) == -good_side ? e.v[0] : e.v[1];
    const Tri& f = s_.triangles[at(p.face)];
    const double depth = std::fabs(dot(n, s_.points[at(wrong)] - p.point));
    out_.list.push_back({{wrong, f.v[0], f.v[1], f.v[2], 0},
                         {1, -p.weights[0], -p.weights[1], -p.weights[2], 0},
                         4,
                         n * (depth + settings_.margin),
                         region_});
  }

  /// Makes a contour shorter at one piercing, with G of contour minimisation bounded where the edge
  /// runs nearly in the plane of the face.
  void shrink(Index k, const Point& pull) {
    const Piercing& p = c_.piercings[at(k)];
    const Edge& e = topology_.edges[at(p.edge)];
    const Point n = unit(face_normal(p.face));
    const Point along = unit(s_.points[at(e.v[1])] - s_.points[at(e.v[0])]);
    const double slope = dot(along, n);
    const double across = std::copysign(std::max(std::fabs(slope), 0.05), slope);
    const Point g = pull - n * (2 * dot(along, pull) / across);
    add(p, e, g * (settings_.step / std::sqrt(1 + length_sq(g))));
  }

  /// Lifts one of two triangles off the other, to the side on which most of it is. Where that is no
  /// side, triangles with lower numbers count as below, and obstacles as below all cloth.
  void part_touching(Index a, Index b) {
    const Index below = b >= s_.cloth_triangle_count ? b : a;
    const Tri& low = s_.triangles[at(below)];
    const Tri& high = s_.triangles[at(below == a ? b : a)];
    const Point n = unit(face_normal(below));
    double height = 0;
    double size = 0;
    for (const Index v : high.v) {
      const Point x = s_.points[at(v)] - s_.points[at(low.v[0])];
      height += dot(n, x);
      size += length(x);
    }
    const double way = height < -1e-9 * size ? -settings_.margin : settings_.margin;
    for (const Index v : high.v)
      if (v != low.v[0] && v != low.v[1] && v != low.v[2])
        out_.list.push_back({{v, low.v[0], low.v[1], low.v[2], 0},
                             {1, -1.0 / 3, -1.0 / 3, -1.0 / 3, 0},
                             4,
                             n * way,
                             -1});
  }

  /// The point of the edge goes by `displacement` relative to that of the face.
  void add(const Piercing& p, const Edge& e, const Point& displacement) {
    const Tri& f = s_.triangles[at(p.face)];
    out_.list.push_back({{e.v[0], e.v[1], f.v[0], f.v[1], f.v[2]},
                         {1 - p.along, p.along, -p.weights[0], -p.weights[1], -p.weights[2]},
                         5,
                         displacement,
                         region_});
  }

  const IntersectingSurfaces& s_;
  const SurfaceTopology& topology_;
  const Contours& c_;
  const CorrectionSettings& settings_;
  std::vector<int> sheet_;
  std::vector<int> crossings_;                 ///< [edges] by the contour that is looked at
  std::array<std::vector<Index>, 2> reached_;  ///< [points] mark of the last flood of either side
  Index marks_ = 0;
  std::vector<Index> walls_;         ///< points that no flood passes
  std::vector<double> half_length_;  ///< [piercings] [m] of the lines that end there
  bool by_solid_ = false;
  Index region_ = -1;  ///< that corrections are for
  Corrections out_;
};

}  // namespace

Corrections find_corrections(const IntersectingSurfaces& surfaces, const SurfaceTopology& topology,
                             const Contours& contours, const CorrectionSettings& settings) {
  return Finder(surfaces, topology, contours, settings).find();
}

}  // namespace weft
