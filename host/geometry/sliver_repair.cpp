#include "host/geometry/sliver_repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "host/geometry/drop_triangles.hpp"
#include "host/geometry/mesh_check.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// [longest edges] A sliver's shortest edge up to this is collapsed: beyond, the surface would move
/// visibly.
constexpr double short_edge = 0.01;

class SliverRemover {
 public:
  SliverRemover(Mesh& mesh, double least)
      : mesh_(mesh), least_(least), around_(mesh.positions.size()) {
    gone_.assign(mesh.triangles.size(), false);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const Index v : mesh.triangles[t].v) around_[at(v)].push_back(static_cast<Index>(t));
  }

  SliverRepair run() {
    std::vector<Index> slivers;
    for (Index t = 0; t < static_cast<Index>(gone_.size()); ++t)
      if (is_sliver(shape(t))) slivers.push_back(t);
    // A change may make another one possible.
    for (bool changed = !slivers.empty(); changed;) {
      changed = false;
      for (const Index t : slivers)
        if (!gone_[at(t)] && is_sliver(shape(t))) changed = remove(t) || changed;
    }
    drop_triangles(mesh_, gone_);
    return done_;
  }

 private:
  /// Corners where shapes are measured: material space is a plane at z = 0.
  using Shape = std::array<Vec3<double>, 3>;

  const Tri& triangle(Index t) const { return mesh_.triangles[at(t)]; }
  const Tri& corners(Index t) const {
    return mesh_.material_triangles.empty() ? triangle(t) : mesh_.material_triangles[at(t)];
  }

  Shape shape(const Tri& tri, const Tri& corner) const {
    Shape x;
    for (std::size_t j = 0; j < 3; ++j) {
      if (mesh_.material.empty()) {
        x[j] = mesh_.positions[at(tri.v[j])];
      } else {
        const Vec2<double>& u = mesh_.material[at(corner.v[j])];
        x[j] = {u[0], u[1], 0};
      }
    }
    return x;
  }
  Shape shape(Index t) const { return shape(triangle(t), corners(t)); }

  static Vec3<double> normal(const Shape& x) { return cross(x[1] - x[0], x[2] - x[0]); }

  /// Height over the longest edge, in units of that edge.
  static double height(const Shape& x) {
    double longest_sq = 0;
    for (std::size_t j = 0; j < 3; ++j)
      longest_sq = std::max(longest_sq, length_sq(x[(j + 1) % 3] - x[j]));
    return length(normal(x)) / longest_sq;
  }
  bool is_sliver(const Shape& x) const { return !(height(x) >= least_); }

  static int corner_of(const Tri& tri, Index v) {
    for (int j = 0; j < 3; ++j)
      if (tri.v[j] == v) return j;
    return -1;
  }

  /// The triangles at an edge.
  std::vector<Index> at_edge(Index a, Index b) const {
    std::vector<Index> found;
    for (const Index t : around_[at(a)])
      if (corner_of(triangle(t), b) >= 0) found.push_back(t);
    return found;
  }

  /// The other vertices of the triangles around one.
  std::vector<Index> neighbours(Index v) const {
    std::vector<Index> found;
    for (const Index t : around_[at(v)])
      for (const Index other : triangle(t).v)
        if (other != v) found.push_back(other);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  /// How far the outline turns at a vertex [rad]; -1: it is not part of it.
  double outline_turn(Index v) const {
    std::vector<Vec3<double>> away;
    for (const Index other : neighbours(v))
      if (at_edge(v, other).size() == 1)
        away.push_back(mesh_.positions[at(other)] - mesh_.positions[at(v)]);
    if (away.empty()) return -1;
    if (away.size() != 2) return 4;  // several outlines meet
    return std::acos(
        std::clamp(-dot(away[0], away[1]) / (length(away[0]) * length(away[1])), -1.0, 1.0));
  }

  bool remove(Index t) {
    const Shape x = shape(t);
    std::array<std::pair<double, int>, 3> edges;
    for (int j = 0; j < 3; ++j) {
      const auto k = static_cast<std::size_t>(j);
      edges[k] = {length(x[(k + 1) % 3] - x[k]), j};
    }
    std::sort(edges.begin(), edges.end());
    if (edges[0].first > short_edge * edges[2].first) return flip(t, edges[2].second);
    const int j = edges[0].second;
    return collapse(triangle(t).v[j], triangle(t).v[(j + 1) % 3]);
  }

  bool collapse(Index a, Index b) {
    const double turn_a = outline_turn(a);
    const double turn_b = outline_turn(b);
    const std::vector<Index> edge = at_edge(a, b);
    if (turn_a >= 0 && turn_b >= 0 && edge.size() != 1) return false;
    // The vertices that both ends know are those across the edge, or the surface would meet itself.
    const std::vector<Index> of_a = neighbours(a);
    const std::vector<Index> of_b = neighbours(b);
    std::vector<Index> common;
    std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                          std::back_inserter(common));
    if (common.size() != edge.size()) return false;
    const bool keep_a = turn_a != turn_b ? turn_a > turn_b : a < b;
    const Index kept = keep_a ? a : b;
    const Index leaving = keep_a ? b : a;
    // An end that is alone on the outline stays.
    const bool either = (turn_a < 0) == (turn_b < 0);
    return collapse_to(leaving, kept) || (either && collapse_to(kept, leaving));
  }

  bool collapse_to(Index leaving, Index kept) {
    const std::vector<Index> edge = at_edge(leaving, kept);
    const auto corner_at = [&](Index t, Index v) {
      return corners(t).v[corner_of(triangle(t), v)];
    };
    const Index end = corner_at(edge[0], kept);
    const Index start = corner_at(edge[0], leaving);
    for (const Index t : edge)
      if (corner_at(t, kept) != end) return false;
    struct Moved {
      Index triangle;
      Tri tri, corner;
    };
    std::vector<Moved> moved;
    for (const Index t : around_[at(leaving)]) {
      if (corner_at(t, leaving) != start) return false;
      const int j = corner_of(triangle(t), leaving);
      if (corner_of(triangle(t), kept) >= 0) continue;
      Moved m{t, triangle(t), corners(t)};
      m.tri.v[j] = kept;
      m.corner.v[j] = end;
      if (!keeps_side(t, m.tri, m.corner)) return false;
      moved.push_back(m);
    }
    for (const Index t : edge) take_out(t);
    for (const Moved& m : moved) put(m.triangle, m.tri, m.corner);
    ++done_.collapsed;
    return true;
  }

  /// Whether a triangle looks the same way once it has other corners, in material space and in the
  /// world.
  bool keeps_side(Index t, const Tri& tri, const Tri& corner) const {
    const Shape before = shape(t);
    const Shape after = shape(tri, corner);
    // The side of what has no area is not known, and it goes before long.
    if (!(height(before) > min_relative_height)) return is_sliver(after);
    if (!(dot(normal(before), normal(after)) > 0)) return false;
    if (mesh_.material.empty() || is_sliver(before)) return true;
    return dot(world_normal(triangle(t)), world_normal(tri)) > 0;
  }
  Vec3<double> world_normal(const Tri& tri) const {
    return normal({mesh_.positions[at(tri.v[0])], mesh_.positions[at(tri.v[1])],
                   mesh_.positions[at(tri.v[2])]});
  }

  /// @param j of the corner where the edge begins
  bool flip(Index t, int j) {
    const Index a = triangle(t).v[j], b = triangle(t).v[(j + 1) % 3],
                c = triangle(t).v[(j + 2) % 3];
    const std::vector<Index> edge = at_edge(a, b);
    if (edge.size() == 1) {
      if (outline_turn(c) >= 0) return false;
      take_out(t);
      ++done_.dropped;
      return true;
    }
    const Index s = edge[0] == t ? edge[1] : edge[0];
    const int k = corner_of(triangle(s), b);  // which runs from b to a
    const Index d = triangle(s).v[(k + 2) % 3];
    const Tri own = corners(t), other = corners(s);
    if (own.v[j] != other.v[(k + 1) % 3] || own.v[(j + 1) % 3] != other.v[k] || c == d)
      return false;
    if (!mesh_.group.empty() && mesh_.group[at(s)] != mesh_.group[at(t)]) return false;
    if (!at_edge(c, d).empty()) return false;
    const Index ua = own.v[j], ub = own.v[(j + 1) % 3], uc = own.v[(j + 2) % 3];
    const Index ud = other.v[(k + 2) % 3];
    const Tri first{{a, d, c}}, second{{d, b, c}};
    const Tri first_corner{{ua, ud, uc}}, second_corner{{ud, ub, uc}};
    if (!keeps_side(s, first, first_corner) || !keeps_side(s, second, second_corner)) return false;
    const double before = std::min(height(shape(t)), height(shape(s)));
    if (!(std::min(height(shape(first, first_corner)), height(shape(second, second_corner))) >
          before))
      return false;
    take_out(t);
    take_out(s);
    put_back(t, first, first_corner);
    put_back(s, second, second_corner);
    ++done_.flipped;
    return true;
  }

  void take_out(Index t) {
    gone_[at(t)] = true;
    for (const Index v : triangle(t).v) std::erase(around_[at(v)], t);
  }
  void put(Index t, const Tri& tri, const Tri& corner) {
    take_out(t);
    put_back(t, tri, corner);
  }
  void put_back(Index t, const Tri& tri, const Tri& corner) {
    gone_[at(t)] = false;
    mesh_.triangles[at(t)] = tri;
    if (!mesh_.material_triangles.empty()) mesh_.material_triangles[at(t)] = corner;
    for (const Index v : tri.v) around_[at(v)].push_back(t);
  }

  Mesh& mesh_;
  double least_;
  std::vector<std::vector<Index>> around_;  ///< [vertices] triangles
  std::vector<bool> gone_;                  ///< [triangles]
  SliverRepair done_;
};

}  // namespace

SliverRepair repair_slivers(Mesh& mesh, double least) {
  return SliverRemover(mesh, least).run();
}

}  // namespace weft
