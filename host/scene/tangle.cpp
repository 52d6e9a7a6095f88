#include "host/scene/tangle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/plane_side.hpp"
#include "host/scene/sewing.hpp"
#include "weft/elements/distance.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;
using Corners = std::array<Point, 3>;

/// Gap below which features count as touching, in units of the longest side of the triangles'
/// boxes. Far above the rounding of a transform or a distance, far below any gap made on purpose.
constexpr double touching = 1e-12;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

// ---- two triangles

/// True where the inside of the segment pq runs through the inside of the triangle.
bool pierces(const Point& p, const Point& q, const Corners& t) {
  const int side_p = plane_side(t[0], t[1], t[2], p);
  if (side_p == 0 || plane_side(t[0], t[1], t[2], q) != -side_p) return false;
  const int turn = plane_side(p, q, t[0], t[1]);
  return turn != 0 && plane_side(p, q, t[1], t[2]) == turn && plane_side(p, q, t[2], t[0]) == turn;
}

/// True if a plane across the line of centres, along a face, or upright on one along an edge, keeps
/// the triangles farther apart than `gap` in spite of rounding. False may be either.
bool plainly_apart(const Corners& s, const Corners& t, double gap) {
  std::array<Point, 6> x;
  double reach = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    x[k] = (k < 3 ? s[k] : t[k - 3]) - s[0];
    for (int c = 0; c < 3; ++c) reach = std::max(reach, std::fabs(x[k][c]));
  }
  const auto separates = [&](const Point& axis) {
    std::array<double, 6> h;
    for (std::size_t k = 0; k < 6; ++k) h[k] = dot(axis, x[k]);
    const double between = std::max(std::min({h[0], h[1], h[2]}) - std::max({h[3], h[4], h[5]}),
                                    std::min({h[3], h[4], h[5]}) - std::max({h[0], h[1], h[2]}));
    const double size = std::fabs(axis[0]) + std::fabs(axis[1]) + std::fabs(axis[2]);
    return between > size * (gap + 16 * epsilon<double> * reach) + smallest_normal<double>;
  };
  // Any axis will do to show a gap; the line of the centres is a good first guess.
  if (separates((x[3] + x[4] + x[5]) - (x[0] + x[1] + x[2]))) return true;
  const std::array<Point, 2> normals{cross(x[1], x[2]), cross(x[4] - x[3], x[5] - x[3])};
  if (separates(normals[0]) || separates(normals[1])) return true;
  for (const Point& normal : normals)
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t next = k < 3 ? (k + 1) % 3 : 3 + (k + 1) % 3;
      if (separates(cross(normal, x[next] - x[k]))) return true;
    }
  return false;
}

/// The same for what of two triangles with one common vertex, corner i of s and j of t, must not
/// meet: the edge opposite it of each, and the other triangle.
bool plainly_apart_beyond(const Corners& s, std::size_t i, const Corners& t, std::size_t j,
                          double gap) {
  return plainly_apart({s[(i + 1) % 3], s[(i + 2) % 3], s[(i + 2) % 3]}, t, gap) &&
         plainly_apart({t[(j + 1) % 3], t[(j + 2) % 3], t[(j + 2) % 3]}, s, gap);
}

/// Longest side of the box about both triangles.
double longest_side(const Corners& s, const Corners& t) {
  double longest = 0;
  for (int c = 0; c < 3; ++c)
    longest =
        std::max(longest, std::max({s[0][c], s[1][c], s[2][c], t[0][c], t[1][c], t[2][c]}) -
                              std::min({s[0][c], s[1][c], s[2][c], t[0][c], t[1][c], t[2][c]}));
  return longest;
}

/// True if two triangles with a common edge lie on opposite sides of a plane through it, and have
/// no corner near enough to the plane or to another for what they do not share to touch.
bool opens_wide(const Corners& s, const Corners& t, const std::array<bool, 3>& s_shared,
                const std::array<bool, 3>& t_shared) {
  const std::size_t i = s_shared[0] ? (s_shared[1] ? 2 : 1) : 0;
  const std::size_t j = t_shared[0] ? (t_shared[1] ? 2 : 1) : 0;
  const Point& start = s[(i + 1) % 3];
  const Point edge = s[(i + 2) % 3] - start;
  const double edge_sq = length_sq(edge);
  const auto height = [&](const Point& x) {
    return (x - start) - edge * (dot(x - start, edge) / edge_sq);
  };
  const Point s_height = height(s[i]);
  const Point t_height = height(t[j]);
  const double size = longest_side(s, t);
  const double least_sq = 1e-4 * size * size;
  const double across = -dot(s_height, t_height);
  return edge_sq > least_sq && across > 0 && across * across > least_sq * length_sq(s_height) &&
         across * across > least_sq * length_sq(t_height);
}

bool vertex_touches(const Point& p, const Corners& t, double gap) {
  const Point x[4] = {p, t[0], t[1], t[2]};
  return !vertex_triangle_farther(x, gap) && vertex_triangle(x).distance_sq <= gap * gap;
}

bool edges_touch(const Point& p, const Point& q, const Point& r, const Point& s, double gap) {
  const Point x[4] = {p, q, r, s};
  return !edge_edge_farther(x, gap) && edge_edge(x).distance_sq <= gap * gap;
}

/// Whether features of the two triangles that share no vertex touch, or one pierces the other.
/// Two triangles that have a point in common other than a shared vertex or edge always do so: where
/// their common part ends, an edge of one runs into the other.
bool triangles_intersect(const Tri& s_tri, const Tri& t_tri, const Corners& s, const Corners& t) {
  std::array<bool, 3> s_shared{};
  std::array<bool, 3> t_shared{};
  std::size_t shared = 0;
  std::size_t s_last = 0;
  std::size_t t_last = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (s_tri.v[i] == t_tri.v[j]) {
        s_shared[s_last = i] = t_shared[t_last = j] = true;
        ++shared;
      }
  const double gap = touching * longest_side(s, t);
  if (shared == 0 && plainly_apart(s, t, gap)) return false;
  if (shared == 1 && plainly_apart_beyond(s, s_last, t, t_last, gap)) return false;
  if (shared == 2 && opens_wide(s, t, s_shared, t_shared)) return false;

  for (std::size_t i = 0; i < 3; ++i) {
    if (!s_shared[i] && vertex_touches(s[i], t, gap)) return true;
    if (!t_shared[i] && vertex_touches(t[i], s, gap)) return true;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t i2 = (i + 1) % 3;
    if (!s_shared[i] && !s_shared[i2] && pierces(s[i], s[i2], t)) return true;
    if (!t_shared[i] && !t_shared[i2] && pierces(t[i], t[i2], s)) return true;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t j2 = (j + 1) % 3;
      const auto same = [&](std::size_t a, std::size_t b) { return s_tri.v[a] == t_tri.v[b]; };
      if (!same(i, j) && !same(i, j2) && !same(i2, j) && !same(i2, j2) &&
          edges_touch(s[i], s[i2], t[j], t[j2], gap))
        return true;
    }
  }
  return false;
}

// ---- which two to test

struct Box {
  Point lo{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Point hi = -lo;

  void include(const Point& low, const Point& high) {
    for (int c = 0; c < 3; ++c) {
      lo[c] = std::min(lo[c], low[c]);
      hi[c] = std::max(hi[c], high[c]);
    }
  }
  bool overlaps(const Box& b) const {
    for (int c = 0; c < 3; ++c)
      if (lo[c] > b.hi[c] || b.lo[c] > hi[c]) return false;
    return true;
  }
};

/// Every mesh of the scene at time 0: cloths, then obstacles, each in its input order.
struct Surfaces {
  std::vector<Point> points;  ///< [m]
  std::vector<Tri> triangles;
  std::vector<Index> first_point;     ///< [meshes + 1]
  std::vector<Index> first_triangle;  ///< [meshes + 1]

  void add(const Mesh& mesh) {
    const Index first = first_point.back();
    points.insert(points.end(), mesh.positions.begin(), mesh.positions.end());
    for (const Tri& t : mesh.triangles)
      triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
    first_point.push_back(static_cast<Index>(points.size()));
    first_triangle.push_back(static_cast<Index>(triangles.size()));
  }
  Corners corners(Index t) const {
    const Tri& tri = triangles[at(t)];
    return {points[at(tri.v[0])], points[at(tri.v[1])], points[at(tri.v[2])]};
  }
};

Surfaces surfaces_at_start(const Scene& scene, const std::vector<unsigned char>& welded) {
  Surfaces all{{}, {}, {0}, {0}};
  for (const Cloth& cloth : scene.cloths) all.add(cloth.mesh);
  const std::vector<Index> joined = joined_inputs(scene, welded);
  average_joined(joined, all.points);
  for (Tri& t : all.triangles)
    for (Index& v : t.v) v = joined[at(v)];
  for (const Obstacle& obstacle : scene.obstacles) {
    const Index first = all.first_point.back();
    all.add(obstacle.mesh);
    if (obstacle.deformation)
      obstacle.deformation->positions(
          0, Span<Point>(all.points.data() + at(first), all.points.size() - at(first)));
    const Transform placed =
        obstacle.motion.empty() ? obstacle.transform : transform_at(obstacle.motion, 0);
    for (std::size_t i = at(first); i < all.points.size(); ++i)
      all.points[i] = apply(placed, all.points[i]);
  }
  return all;
}

/// Boxes of a run of triangles as a complete binary tree, halved by the median along the longest
/// side, so that its depth is bounded whatever the sizes of the triangles. Node k has the children
/// 2k and 2k + 1; nodes from leaf_count on are leaves of at most four triangles.
struct BoxTree {
  struct Item {
    Box box;
    Index triangle;
    double centre_twice(int axis) const { return box.lo[axis] + box.hi[axis]; }
  };
  std::vector<Item> items;
  std::vector<Box> nodes;
  std::vector<std::size_t> leaf_first;  ///< [leaf_count + 1] into items
  std::size_t leaf_count = 1;

  /// @param first,last run of triangles
  BoxTree(const Surfaces& surfaces, Index first, Index last) {
    for (Index t = first; t < last; ++t) {
      Box box;
      for (const Point& x : surfaces.corners(t)) box.include(x, x);
      const Point span = box.hi - box.lo;
      const double pad = touching * std::max({span[0], span[1], span[2]});
      const Point corner{pad, pad, pad};
      items.push_back({{box.lo - corner, box.hi + corner}, t});
    }
    while (4 * leaf_count < items.size()) leaf_count *= 2;
    nodes.resize(2 * leaf_count);
    leaf_first.assign(leaf_count + 1, items.size());
    build(1, 0, items.size());
  }

 private:
  void build(std::size_t node, std::size_t first, std::size_t last) {
    Box& box = nodes[node];
    for (std::size_t i = first; i < last; ++i) box.include(items[i].box.lo, items[i].box.hi);
    if (node >= leaf_count) {
      leaf_first[node - leaf_count] = first;
      return;
    }
    const Point span = box.hi - box.lo;
    const int axis =
        span[0] >= span[1] ? (span[0] >= span[2] ? 0 : 2) : (span[1] >= span[2] ? 1 : 2);
    const std::size_t middle = first + (last - first) / 2;
    const auto begin = items.begin();
    std::nth_element(
        begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
        begin + static_cast<std::ptrdiff_t>(last),
        [&](const Item& a, const Item& b) { return a.centre_twice(axis) < b.centre_twice(axis); });
    build(2 * node, first, middle);
    build(2 * node + 1, middle, last);
  }
};

/// Calls visit(triangle of s, triangle of t) where boxes below node a of s and node b of t overlap.
template <class Visit>
void visit_pairs(const BoxTree& s, std::size_t a, const BoxTree& t, std::size_t b, Visit& visit) {
  if (!s.nodes[a].overlaps(t.nodes[b])) return;
  const bool a_leaf = a >= s.leaf_count;
  const bool b_leaf = b >= t.leaf_count;
  if (a_leaf && b_leaf) {
    for (std::size_t i = s.leaf_first[a - s.leaf_count]; i < s.leaf_first[a - s.leaf_count + 1];
         ++i)
      for (std::size_t j = t.leaf_first[b - t.leaf_count]; j < t.leaf_first[b - t.leaf_count + 1];
           ++j)
        if (s.items[i].box.overlaps(t.items[j].box))
          visit(s.items[i].triangle, t.items[j].triangle);
  } else if (b_leaf || (!a_leaf && a <= b)) {
    visit_pairs(s, 2 * a, t, b, visit);
    visit_pairs(s, 2 * a + 1, t, b, visit);
  } else {
    visit_pairs(s, a, t, 2 * b, visit);
    visit_pairs(s, a, t, 2 * b + 1, visit);
  }
}

/// The same for each two triangles of one tree, once.
template <class Visit>
void visit_own_pairs(const BoxTree& t, std::size_t node, Visit& visit) {
  if (node < t.leaf_count) {
    visit_own_pairs(t, 2 * node, visit);
    visit_own_pairs(t, 2 * node + 1, visit);
    visit_pairs(t, 2 * node, t, 2 * node + 1, visit);
    return;
  }
  const std::size_t last = t.leaf_first[node - t.leaf_count + 1];
  for (std::size_t i = t.leaf_first[node - t.leaf_count]; i < last; ++i)
    for (std::size_t j = i + 1; j < last; ++j)
      if (t.items[i].box.overlaps(t.items[j].box)) visit(t.items[i].triangle, t.items[j].triangle);
}

// ---- what to say

/// Such as "cloths[0]" and its name; meshes are counted through cloths, then obstacles.
std::pair<std::string, std::string> field_and_name(const Scene& scene, std::size_t mesh) {
  const std::size_t cloths = scene.cloths.size();
  if (mesh < cloths) return {"cloths[" + std::to_string(mesh) + "]", scene.cloths[mesh].name};
  const std::size_t o = mesh - cloths;
  return {"obstacles[" + std::to_string(o) + "]", scene.obstacles[o].name};
}

/// The name the scene gives, or the field if it gives none.
std::string name_of(const Scene& scene, std::size_t mesh) {
  const auto [field, name] = field_and_name(scene, mesh);
  return name.empty() ? field : name;
}

/// "cloths[0] (sheet)"
std::string title_of(const Scene& scene, std::size_t mesh) {
  const auto [field, name] = field_and_name(scene, mesh);
  return name.empty() ? field : field + " (" + name + ")";
}

/// Counts pairs of triangles and keeps the lowest few.
class FoundPairs {
 public:
  void add(Index a, Index b) {
    ++count_;
    lowest_.emplace_back(std::min(a, b), std::max(a, b));
    std::sort(lowest_.begin(), lowest_.end());
    if (lowest_.size() > shown_max) lowest_.pop_back();
  }
  void refuse_any(const Scene& scene, const Surfaces& surfaces) const {
    if (count_ == 0) return;
    const auto mesh_of = [&](Index t) {
      const auto& first = surfaces.first_triangle;
      return static_cast<std::size_t>(std::upper_bound(first.begin(), first.end(), t) -
                                      first.begin() - 1);
    };
    std::string list;
    for (const auto& [a, b] : lowest_) {
      const std::size_t s = mesh_of(a);
      const std::size_t t = mesh_of(b);
      list += list.empty() ? "triangles " : ", ";
      list += std::to_string(a - surfaces.first_triangle[s]);
      if (s != t) list += " of " + name_of(scene, s);
      list += " and " + std::to_string(b - surfaces.first_triangle[t]) + " of " + name_of(scene, t);
    }
    throw SceneError(scene.file, title_of(scene, mesh_of(lowest_.front().first)),
                     list + " intersect, " + std::to_string(count_) +
                         (count_ == 1 ? " pair in all" : " pairs in all"),
                     "a start free of intersections, touching included");
  }

 private:
  static constexpr std::size_t shown_max = 4;
  std::int64_t count_ = 0;
  std::vector<std::pair<Index, Index>> lowest_;
};

void refuse_intersections(const Scene& scene, const Surfaces& surfaces) {
  const Index cloth_end = surfaces.first_triangle[scene.cloths.size()];
  FoundPairs found;
  const auto visit = [&](Index a, Index b) {
    if (triangles_intersect(surfaces.triangles[at(a)], surfaces.triangles[at(b)],
                            surfaces.corners(a), surfaces.corners(b)))
      found.add(a, b);
  };
  const BoxTree cloth(surfaces, 0, cloth_end);
  if (scene.contact.self) visit_own_pairs(cloth, 1, visit);
  if (!scene.obstacles.empty()) {
    const BoxTree obstacle(surfaces, cloth_end, surfaces.first_triangle.back());
    visit_pairs(cloth, 1, obstacle, 1, visit);
  }
  found.refuse_any(scene, surfaces);
}

// ---- inside an obstacle

/// Whether each edge has two triangles. Meshes that pass check_mesh have none with more.
bool is_closed(const Mesh& mesh) {
  std::vector<std::pair<Index, Index>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Tri& t : mesh.triangles)
    for (int j = 0; j < 3; ++j) edges.emplace_back(std::minmax(t.v[j], t.v[(j + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); i += 2)
    if (i + 1 == edges.size() || edges[i] != edges[i + 1]) return false;
  return true;
}

/// How often the triangles first .. last - 1 wind about x: the sum of their solid angles over 4 pi.
/// With a, b, c from x to the corners,
///   tan(angle / 2) = det[a, b, c] / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)
double winding_number(const Surfaces& surfaces, Index first, Index last, const Point& x) {
  double halves = 0;
  for (Index t = first; t < last; ++t) {
    const Corners r = surfaces.corners(t);
    const Point a = r[0] - x;
    const Point b = r[1] - x;
    const Point c = r[2] - x;
    const double la = length(a);
    const double lb = length(b);
    const double lc = length(c);
    halves += std::atan2(dot(a, cross(b, c)),
                         la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return halves / (2 * std::numbers::pi);
}

/// The lowest vertex of each connected part of a mesh.
std::vector<Index> one_vertex_a_part(const Mesh& mesh) {
  std::vector<Index> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Index v) {
    while (parent[at(v)] != v) v = parent[at(v)] = parent[at(parent[at(v)])];
    return v;
  };
  for (const Tri& t : mesh.triangles)
    for (int j = 1; j < 3; ++j) {
      const auto [low, high] = std::minmax({root(t.v[0]), root(t.v[j])});
      parent[at(high)] = low;
    }
  std::vector<Index> lowest;
  for (Index v = 0; v < static_cast<Index>(parent.size()); ++v)
    if (parent[at(v)] == v) lowest.push_back(v);
  return lowest;
}

/// As nothing intersects, a part with one vertex inside is inside as a whole.
void refuse_inside_obstacles(const Scene& scene, const Surfaces& surfaces) {
  const std::size_t cloths = scene.cloths.size();
  std::vector<std::vector<Index>> probes;
  for (const Cloth& cloth : scene.cloths) probes.push_back(one_vertex_a_part(cloth.mesh));
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    if (!is_closed(scene.obstacles[o].mesh)) continue;
    Box around;
    for (Index v = surfaces.first_point[cloths + o]; v < surfaces.first_point[cloths + o + 1]; ++v)
      around.include(surfaces.points[at(v)], surfaces.points[at(v)]);
    for (std::size_t c = 0; c < cloths; ++c)
      for (const Index v : probes[c]) {
        const Point& x = scene.cloths[c].mesh.positions[at(v)];
        if (!around.overlaps({x, x})) continue;
        if (winding_number(surfaces, surfaces.first_triangle[cloths + o],
                           surfaces.first_triangle[cloths + o + 1], x) > 0.5)
          throw SceneError(scene.file, title_of(scene, c),
                           "a start inside " + title_of(scene, cloths + o) + ", with vertex " +
                               std::to_string(v) + " and all that hangs together with it,",
                           "a start outside of closed obstacles");
      }
  }
}

}  // namespace

void refuse_tangled_start(const Scene& scene, const std::vector<unsigned char>& welded) {
  const Surfaces surfaces = surfaces_at_start(scene, welded);
  refuse_intersections(scene, surfaces);
  refuse_inside_obstacles(scene, surfaces);
}

}  // namespace weft
