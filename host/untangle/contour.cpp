#include "host/untangle/contour.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "host/geometry/tri_has.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

Corners corners_of(const IntersectingSurfaces& s, Index t) {
  const Tri& tri = s.triangles[at(t)];
  return {s.points[at(tri.v[0])], s.points[at(tri.v[1])], s.points[at(tri.v[2])]};
}

/// @pre the edge pierces the face
Piercing piercing_of(const IntersectingSurfaces& s, const Edge& e, Index edge, Index face) {
  const Corners t = corners_of(s, face);
  const Point& p = s.points[at(e.v[0])];
  const Point& q = s.points[at(e.v[1])];
  const Point n = cross(t[1] - t[0], t[2] - t[0]);
  const double hp = std::fabs(dot(n, p - t[0]));
  const double hq = std::fabs(dot(n, q - t[0]));
  const double along = hp + hq > 0 ? hp / (hp + hq) : 0.5;
  const Point x = p + (q - p) * along;
  // Parts of the area; clamped, as rounding may put the point a hair outside.
  Point w;
  for (int j = 0; j < 3; ++j) {
    const auto a = static_cast<std::size_t>((j + 1) % 3);
    const auto b = static_cast<std::size_t>((j + 2) % 3);
    w[j] = std::max(0.0, dot(n, cross(t[a] - x, t[b] - x)));
  }
  const double sum = w[0] + w[1] + w[2];
  w = sum > 0 ? w * (1 / sum) : Point{1.0 / 3, 1.0 / 3, 1.0 / 3};
  return {edge, face, along, w, x};
}

/// The vertex that two triangles share, if it is but one; -1 otherwise.
Index single_shared(const Tri& s, const Tri& t) {
  Index found = -1;
  for (const Index v : s.v) {
    if (!has(t, v)) continue;
    if (found >= 0) return -1;
    found = v;
  }
  return found;
}

/// The line of one pair of triangles, from the piercings that lie on it.
void add_arc(const IntersectingSurfaces& s, const std::vector<Index>& on_line, Index a, Index b,
             Contours& c) {
  const auto point = [&](Index k) { return c.piercings[at(k)].point; };
  if (on_line.size() == 1) {
    const Index corner = single_shared(s.triangles[at(a)], s.triangles[at(b)]);
    if (corner < 0) return;  // where rounding lets one end touch and not pierce
    const double size = length(s.points[at(corner)] - point(on_line[0]));
    c.arcs.push_back({{on_line[0], -1}, corner, {a, b}, size});
    return;
  }
  // More than two lie there only where triangles overlap in a plane but for rounding.
  ContourArc arc{{on_line[0], on_line[1]}, -1, {a, b}, -1};
  for (std::size_t i = 0; i < on_line.size(); ++i)
    for (std::size_t j = i + 1; j < on_line.size(); ++j) {
      const double size = length(point(on_line[j]) - point(on_line[i]));
      if (size > arc.length) arc = {{on_line[i], on_line[j]}, -1, {a, b}, size};
    }
  c.arcs.push_back(arc);
}

void add_arcs(const IntersectingSurfaces& s, const SurfaceTopology& topology, Contours& c) {
  struct End {
    Index a, b, piercing;
  };
  std::vector<End> ends;
  for (std::size_t k = 0; k < c.piercings.size(); ++k) {
    const Piercing& p = c.piercings[k];
    for (Index i = topology.edge_first[at(p.edge)]; i < topology.edge_first[at(p.edge) + 1]; ++i) {
      const auto [a, b] = std::minmax(topology.edge_triangles[at(i)], p.face);
      ends.push_back({a, b, static_cast<Index>(k)});
    }
  }
  std::sort(ends.begin(), ends.end(), [](const End& x, const End& y) {
    return x.a != y.a ? x.a < y.a : (x.b != y.b ? x.b < y.b : x.piercing < y.piercing);
  });
  std::vector<Index> on_line;
  for (std::size_t i = 0; i < ends.size();) {
    on_line.clear();
    std::size_t j = i;
    for (; j < ends.size() && ends[j].a == ends[i].a && ends[j].b == ends[i].b; ++j)
      on_line.push_back(ends[j].piercing);
    add_arc(s, on_line, ends[i].a, ends[i].b, c);
    i = j;
  }
}

/// Numbers the contours in the order of their lowest piercings.
void number_contours(Contours& c) {
  std::vector<Index> parent(c.piercings.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Index k) {
    while (parent[at(k)] != k) k = parent[at(k)] = parent[at(parent[at(k)])];
    return k;
  };
  for (const ContourArc& arc : c.arcs) {
    if (arc.piercing[1] < 0) continue;
    const auto [low, high] = std::minmax({root(arc.piercing[0]), root(arc.piercing[1])});
    parent[at(high)] = low;
  }
  c.number.assign(c.piercings.size(), -1);
  for (std::size_t k = 0; k < c.piercings.size(); ++k) {
    const Index r = root(static_cast<Index>(k));
    if (r == static_cast<Index>(k)) c.number[k] = c.count++;
    c.number[k] = c.number[at(r)];
  }
}

}  // namespace

SurfaceTopology::SurfaceTopology(const std::vector<Tri>& triangles, std::size_t point_count) {
  struct Side {
    Index low, high, triangle, j;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int j = 0; j < 3; ++j) {
      const auto [low, high] = std::minmax(triangles[t].v[j], triangles[t].v[(j + 1) % 3]);
      sides.push_back({low, high, static_cast<Index>(t), j});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.low != b.low     ? a.low < b.low
           : a.high != b.high ? a.high < b.high
                              : a.triangle < b.triangle;
  });
  triangle_edges.resize(triangles.size());
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Side& s = sides[i];
    if (i == 0 || s.low != sides[i - 1].low || s.high != sides[i - 1].high) {
      edges.push_back({{s.low, s.high}});
      edge_first.push_back(static_cast<Index>(i));
    }
    edge_triangles.push_back(s.triangle);
    triangle_edges[at(s.triangle)][at(s.j)] = static_cast<Index>(edges.size()) - 1;
  }
  edge_first.push_back(static_cast<Index>(sides.size()));

  point_first.assign(point_count + 1, 0);
  for (const Edge& e : edges)
    for (const Index v : e.v) ++point_first[at(v) + 1];
  std::partial_sum(point_first.begin(), point_first.end(), point_first.begin());
  std::vector<Index> next(point_first.begin(), point_first.end() - 1);
  neighbours.resize(2 * edges.size());
  point_edges.resize(2 * edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e)
    for (int j = 0; j < 2; ++j) {
      const auto place = at(next[at(edges[e].v[j])]++);
      neighbours[place] = edges[e].v[1 - j];
      point_edges[place] = static_cast<Index>(e);
    }
}

double Contours::length() const {
  double sum = 0;
  for (const ContourArc& arc : arcs) sum += arc.length;
  return sum;
}

ContourSearch::ContourSearch(const IntersectingSurfaces& surfaces, const SurfaceTopology& topology)
    : surfaces_(surfaces),
      topology_(topology),
      cloth_(surfaces.points, surfaces.triangles, 0, surfaces.cloth_triangle_count, touching),
      obstacle_(surfaces.points, surfaces.triangles, surfaces.cloth_triangle_count,
                static_cast<Index>(surfaces.triangles.size()), touching) {}

/// Points that have moved since the last find(), or are awake and were not.
std::vector<unsigned char> ContourSearch::changed_points(Span<const unsigned char> awake) const {
  const std::vector<Point>& now = surfaces_.points;
  std::vector<unsigned char> changed(now.size(), 1);
  if (points_before_.size() != now.size()) return changed;
  for (std::size_t v = 0; v < now.size(); ++v)
    changed[v] = !(now[v] == points_before_[v]) || (awake[v] != 0 && awake_before_[v] == 0);
  return changed;
}

/// Does nothing where obstacles are as they were: they rarely change.
void ContourSearch::refit_obstacles(double pad, Span<const unsigned char> changed) {
  const IntersectingSurfaces& s = surfaces_;
  const auto changes = [&](const Tri& t) {
    return changed[at(t.v[0])] != 0 || changed[at(t.v[1])] != 0 || changed[at(t.v[2])] != 0;
  };
  const bool any =
      std::any_of(s.triangles.begin() + s.cloth_triangle_count, s.triangles.end(), changes);
  if (!any && pad == obstacle_pad_) return;
  obstacle_.refit(s.points, s.triangles, pad, changed);
  obstacle_pad_ = any ? -1 : pad;
}

/// What the last find() found of pairs that have not changed and of which a corner is awake.
Contours ContourSearch::unchanged(Span<const unsigned char> awake,
                                  Span<const unsigned char> changed) const {
  const auto any = [&](Span<const unsigned char> marks, Index a, Index b) {
    for (const Index t : {a, b})
      for (const Index v : surfaces_.triangles[at(t)].v)
        if (marks[at(v)] != 0) return true;
    return false;
  };
  const auto stays = [&](Index a, Index b) { return any(awake, a, b) && !any(changed, a, b); };
  Contours c;
  for (const Piercing& p : piercings_before_)
    if (stays(first_triangle(p.edge), p.face)) c.piercings.push_back(p);
  for (const auto& [a, b] : touching_before_)
    if (stays(a, b)) c.touching.emplace_back(a, b);
  return c;
}

Contours ContourSearch::find(Span<const unsigned char> awake) {
  const IntersectingSurfaces& s = surfaces_;
  const std::vector<unsigned char> changed = changed_points(awake);
  Contours c = unchanged(awake, changed);
  // Every edge is looked at along with the first of its triangles.
  const auto look = [&](Index t, Index face, const Corners& corners, bool& any) {
    for (const Index e : topology_.triangle_edges[at(t)]) {
      const Edge& edge = topology_.edges[at(e)];
      const Tri& f = s.triangles[at(face)];
      if (has(f, edge.v[0]) || has(f, edge.v[1])) continue;
      if (!pierces(s.points[at(edge.v[0])], s.points[at(edge.v[1])], corners)) continue;
      any = true;
      if (first_triangle(e) == t) c.piercings.push_back(piercing_of(s, edge, e, face));
    }
  };
  const auto is_awake = [&](Index t) {
    const Tri& tri = s.triangles[at(t)];
    return awake[at(tri.v[0])] != 0 || awake[at(tri.v[1])] != 0 || awake[at(tri.v[2])] != 0;
  };
  double reach = 0;
  for (const Point& x : s.points)
    for (int k = 0; k < 3; ++k) reach = std::max(reach, std::fabs(x[k]));
  refit_obstacles(2 * touching * reach, changed);
  visit_with_cloth(2 * touching * reach, changed, [&](Index a, Index b) {
    if (!is_awake(a) && !is_awake(b)) return;
    const Corners s_corners = corners_of(s, a);
    const Corners t_corners = corners_of(s, b);
    if (!triangles_intersect(s.triangles[at(a)], s.triangles[at(b)], s_corners, t_corners)) return;
    bool any = false;
    look(a, b, t_corners, any);
    look(b, a, s_corners, any);
    if (!any) c.touching.emplace_back(std::minmax(a, b));
  });
  std::sort(c.touching.begin(), c.touching.end());
  std::sort(c.piercings.begin(), c.piercings.end(), [](const Piercing& p, const Piercing& q) {
    return p.edge != q.edge ? p.edge < q.edge : p.face < q.face;
  });
  points_before_ = s.points;
  awake_before_.assign(awake.begin(), awake.end());
  piercings_before_ = c.piercings;
  touching_before_ = c.touching;
  add_arcs(s, topology_, c);
  number_contours(c);
  return c;
}

ContourKind kind_of(const Contours& contours, Index contour) {
  std::vector<int> lines(contours.piercings.size(), 0);
  for (const ContourArc& arc : contours.arcs) {
    if (contours.number[at(arc.piercing[0])] != contour) continue;
    if (arc.corner >= 0) return ContourKind::boundary;
    for (const Index k : arc.piercing) ++lines[at(k)];
  }
  for (std::size_t k = 0; k < lines.size(); ++k)
    if (contours.number[k] == contour && lines[k] < 2) return ContourKind::boundary;
  return ContourKind::closed;
}

std::vector<Vec3<double>> contour_pull(const IntersectingSurfaces& surfaces,
                                       const Contours& contours) {
  std::vector<Point> pull(contours.piercings.size(), Point{0, 0, 0});
  for (const ContourArc& arc : contours.arcs) {
    if (!(arc.length > 0)) continue;
    const Point start = contours.piercings[at(arc.piercing[0])].point;
    const Point end = arc.piercing[1] >= 0 ? contours.piercings[at(arc.piercing[1])].point
                                           : surfaces.points[at(arc.corner)];
    const Point direction = (end - start) * (1 / arc.length);
    pull[at(arc.piercing[0])] += direction;
    if (arc.piercing[1] >= 0) pull[at(arc.piercing[1])] -= direction;
  }
  return pull;
}

std::vector<Vec3<double>> contour_gradient(const IntersectingSurfaces& surfaces,
                                           const SurfaceTopology& topology,
                                           const Contours& contours) {
  std::vector<Point> gradient(surfaces.points.size(), Point{0, 0, 0});
  const std::vector<Point> pull = contour_pull(surfaces, contours);
  for (std::size_t k = 0; k < pull.size(); ++k) {
    const Piercing& p = contours.piercings[k];
    const Edge& e = topology.edges[at(p.edge)];
    const Corners t = corners_of(surfaces, p.face);
    const Point n = cross(t[1] - t[0], t[2] - t[0]);
    const Point along = surfaces.points[at(e.v[1])] - surfaces.points[at(e.v[0])];
    const double across = dot(along, n);
    if (across == 0) continue;
    const Point of_face = n * (dot(along, pull[k]) / across);
    const Point of_edge = pull[k] - of_face;
    gradient[at(e.v[0])] -= of_edge * (1 - p.along);
    gradient[at(e.v[1])] -= of_edge * p.along;
    for (int j = 0; j < 3; ++j)
      gradient[at(surfaces.triangles[at(p.face)].v[j])] -= of_face * p.weights[j];
  }
  for (const ContourArc& arc : contours.arcs)
    if (arc.corner >= 0 && arc.length > 0)
      gradient[at(arc.corner)] +=
          (surfaces.points[at(arc.corner)] - contours.piercings[at(arc.piercing[0])].point) *
          (1 / arc.length);
  return gradient;
}

}  // namespace weft
