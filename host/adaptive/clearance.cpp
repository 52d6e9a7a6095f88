#include "host/adaptive/clearance.hpp"

#include <algorithm>
#include <cmath>

#include "weft/core/at.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

Aabb box_of(const Corners& c, double pad) {
  Aabb box;
  for (const Vec3<double>& x : c) box.include(x, x);
  double size = pad;
  for (int k = 0; k < 3; ++k) size = std::max(size, touching * 4 * (box.hi[k] - box.lo[k]));
  const Vec3<double> by{size, size, size};
  box.lo -= by;
  box.hi += by;
  return box;
}

/// Triangles this many times as far apart as the gap are so in spite of rounding.
constexpr double gap_separation_bound = 1.001;

bool share_a_vertex(const Tri& a, const Tri& b) {
  for (const Index i : a.v)
    for (const Index j : b.v)
      if (i == j) return true;
  return false;
}

/// Whether two triangles without a common vertex, which do not meet, come closer than `gap`.
bool closer(const Corners& s, const Corners& t, double gap) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3<double> a[4] = {s[i], t[0], t[1], t[2]};
    const Vec3<double> b[4] = {t[i], s[0], s[1], s[2]};
    if (!vertex_triangle_farther(a, gap) && vertex_triangle(a).distance_sq < gap * gap) return true;
    if (!vertex_triangle_farther(b, gap) && vertex_triangle(b).distance_sq < gap * gap) return true;
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec3<double> e[4] = {s[i], s[(i + 1) % 3], t[j], t[(j + 1) % 3]};
      if (!edge_edge_farther(e, gap) && edge_edge(e).distance_sq < gap * gap) return true;
    }
  }
  return false;
}

/// Whether two triangles meet, or come closer than `gap` without a common vertex.
bool meet(const PlacedTriangle& s, const PlacedTriangle& t, double gap) {
  const bool keeps_gap = gap > 0 && !share_a_vertex(s.places, t.places);
  // One test for both: farther than the gap, and than what counts as touching.
  if (keeps_gap &&
      plainly_apart(s.x, t.x, gap_separation_bound * gap + touching * (s.girth + t.girth)))
    return false;
  return triangles_intersect(s.places, t.places, s.x, t.x) || (keeps_gap && closer(s.x, t.x, gap));
}

/// [triangles] of those that are there
std::vector<Aabb> boxes_of(const SurfaceMesh& mesh) {
  std::vector<Aabb> boxes(mesh.triangles.size());
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const Tri& t = mesh.triangles[k];
    if (mesh.kind[k] >= 0)
      boxes[k] = box_of(
          {mesh.positions[at(t.v[0])], mesh.positions[at(t.v[1])], mesh.positions[at(t.v[2])]}, 0);
  }
  return boxes;
}

/// [triangles] of those that the cloth may come near to: no remesh leads out of its box.
std::vector<Aabb> boxes_of(const Surroundings& around, const SurfaceMesh& mesh, double reach) {
  Aabb cloth;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (mesh.leaving[v] >= 0) cloth.include(mesh.positions[v], mesh.positions[v]);
  double pad = std::max(reach, around.gap);
  // Rounding to single precision, and touching.
  for (int c = 0; c < 3; ++c) pad += 1e-6 * std::max(std::abs(cloth.lo[c]), std::abs(cloth.hi[c]));
  const Vec3<double> by{pad, pad, pad};
  cloth.lo -= by;
  cloth.hi += by;
  std::vector<Aabb> boxes(around.triangles.size());
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const Tri& t = around.triangles[k];
    const Aabb box = box_of(
        {around.positions[at(t.v[0])], around.positions[at(t.v[1])], around.positions[at(t.v[2])]},
        0);
    if (box.overlaps(cloth)) boxes[k] = box;
  }
  return boxes;
}

}  // namespace

Clearance::Clearance(const SurfaceMesh& mesh, const Surroundings& around, double reach)
    : mesh_(mesh),
      around_(around),
      cloth_(around.self ? boxes_of(mesh) : std::vector<Aabb>{}),
      obstacle_(boxes_of(around, mesh, reach)),
      in_tree_(mesh.triangles.size(), 0) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) in_tree_[t] = mesh.kind[t] >= 0 ? 1 : 0;
}

Corners Clearance::corners_of(const Tri& t) const {
  return {mesh_.positions[at(t.v[0])], mesh_.positions[at(t.v[1])], mesh_.positions[at(t.v[2])]};
}

Tri Clearance::places_of(const Tri& t) const {
  return {{mesh_.place[at(t.v[0])], mesh_.place[at(t.v[1])], mesh_.place[at(t.v[2])]}};
}

Corners Clearance::obstacle_corners(Index t) const {
  const Tri& tri = around_.triangles[at(t)];
  return {around_.positions[at(tri.v[0])], around_.positions[at(tri.v[1])],
          around_.positions[at(tri.v[2])]};
}

bool Clearance::is_clear(const std::vector<Tri>& fresh, const std::vector<Index>& gone,
                         bool keep_gap) const {
  const double gap = keep_gap ? around_.gap : 0;
  // What is near one of them is near their common box: one way through the trees serves all.
  Aabb all;
  fresh_.clear();
  for (const Tri& tri : fresh) {
    const Corners own = corners_of(tri);
    const Aabb box = box_of(own, gap);
    all.include(box.lo, box.hi);
    fresh_.push_back({{places_of(tri), own, box.girth()}, box});
  }
  near_.clear();
  const auto add = [&](const Tri& places, const Corners& x, const Aabb& box) {
    near_.push_back({{places, x, box.girth()}, box});
  };
  if (around_.self)
    cloth_.overlapping(all, [&](Index t) {
      if (std::find(gone.begin(), gone.end(), t) != gone.end()) return;
      const Tri& tri = mesh_.triangles[at(t)];
      add(places_of(tri), corners_of(tri), cloth_.box(t));
    });
  obstacle_.overlapping(all, [&](Index t) {
    // numbers that no cloth vertex has
    add({{-1 - 3 * t, -2 - 3 * t, -3 - 3 * t}}, obstacle_corners(t), obstacle_.box(t));
  });
  for (std::size_t k = 0; k < fresh_.size(); ++k) {
    const PlacedTriangle& own = fresh_[k].triangle;
    const CullingPlanes planes(own);
    for (std::size_t l = 0; l < k; ++l) {
      const PlacedTriangle& other = fresh_[l].triangle;
      if (!planes.holds_off(other, 0) &&
          triangles_intersect(own.places, other.places, own.x, other.x))
        return false;
    }
    for (const Near& other : near_)
      if (other.box.overlaps(fresh_[k].box) &&
          !planes.holds_off(other.triangle, gap_separation_bound * gap) &&
          meet(own, other.triangle, gap))
        return false;
  }
  return true;
}

void Clearance::update(const std::vector<Index>& triangles) {
  if (!around_.self) return;
  for (const Index t : triangles) {
    if (in_tree_.size() <= at(t)) in_tree_.resize(at(t) + 1, 0);
    const bool was = in_tree_[at(t)] != 0;
    const bool is = mesh_.alive(t);
    in_tree_[at(t)] = is ? 1 : 0;
    if (was && !is) cloth_.remove(t);
    if (!is) continue;
    const Aabb box = box_of(corners_of(mesh_.triangles[at(t)]), 0);
    if (was)
      cloth_.replace(t, box);
    else
      cloth_.insert(t, box);
  }
}

Clearance::Plane Clearance::nearest_obstacle(const Vec3<double>& x, double reach,
                                             Index guess) const {
  Plane plane{{0, 0, 0}, {0, 0, 0}};
  double nearest = reach * reach;
  // Boxes at the distance of the nearest are looked at in spite of rounding.
  const auto in_spite_of_rounding = [](double distance) { return distance * (1 + 1e-9) + 1e-12; };
  double within = in_spite_of_rounding(reach);
  const auto look = [&](Index t) {
    const Corners c = obstacle_corners(t);
    const Vec3<double> corners[4] = {x, c[0], c[1], c[2]};
    const Proximity<double> p = vertex_triangle(corners);
    if (p.distance_sq > nearest ||
        (p.distance_sq == nearest && plane.triangle >= 0 && plane.triangle <= t))
      return within;
    const Vec3<double> way = p.difference;
    const double distance = length(way);
    if (!(distance > 0)) return within;
    nearest = p.distance_sq;
    plane = {x - way, (1 / distance) * way, t};
    within = in_spite_of_rounding(distance);
    return within;
  };
  if (guess >= 0) look(guess);
  obstacle_.around(x, within, look);
  return plane;
}

}  // namespace weft
