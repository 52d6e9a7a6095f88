#include "host/model/start_thickness.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "host/base/parallel.hpp"
#include "host/geometry/box_tree.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "host/model/surface_tables.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/contact.hpp"
#include "weft/elements/pair_lanes.hpp"
#include "weft/elements/rest_distance.hpp"

namespace weft {
namespace {

/// Gaps of at least this share of the thickness count as the thickness: sheets laid that far apart
/// miss it by rounding.
constexpr double full_share = 1 - 1e-6;

/// By how much a vertex of a cloth that counts as flat may lie beside its place, over the
/// thickness. Where two primitives of such a cloth are nearer than the thickness, they are as near
/// at rest to twice this, and so are neighbours.
constexpr double flat_share = (1 / rest_share - 1) * 0.4;

/// Whether these vertices lie as in material space, in some plane.
/// @param v ascending
bool are_flat(const Model& m, const std::vector<Index>& v, double tolerance) {
  using Vec = Vec3<double>;
  const auto rest = [&](Index i) {
    const Vec2<double>& u = m.material_points[at(i)];
    return Vec{u[0], u[1], 0};
  };
  const auto farthest = [&](const auto& distance_sq) {
    return *std::max_element(v.begin(), v.end(), [&](Index a, Index b) {
      return distance_sq(rest(a)) < distance_sq(rest(b));
    });
  };
  // The axes of a frame through three vertices that are far apart, at rest and in the world.
  const Index a = v.front();
  const Index b = farthest([&](const Vec& u) { return length_sq(u - rest(a)); });
  const Vec along = rest(b) - rest(a);
  if (!(length_sq(along) > 0)) return false;
  const Index c = farthest(
      [&](const Vec& u) { return length_sq(cross(u - rest(a), along)) / length_sq(along); });
  const auto axes = [&](const Vec& origin, const Vec& first, const Vec& second) {
    const Vec e = (first - origin) * (1 / length(first - origin));
    const Vec n = second - origin - dot(second - origin, e) * e;
    return std::array<Vec, 2>{e, n * (1 / length(n))};
  };
  const auto at_rest = axes(rest(a), rest(b), rest(c));
  const auto placed = axes(m.positions[at(a)], m.positions[at(b)], m.positions[at(c)]);
  return std::all_of(v.begin(), v.end(), [&](Index i) {
    const Vec u = rest(i) - rest(a);
    const Vec x =
        m.positions[at(a)] + dot(u, at_rest[0]) * placed[0] + dot(u, at_rest[1]) * placed[1];
    return length_sq(m.positions[at(i)] - x) <= tolerance * tolerance;
  });
}

/// @return [cloths] 1 where the vertices of one are_flat()
std::vector<unsigned char> flat_cloths(const Model& m, double thickness) {
  std::vector<std::vector<Index>> vertices;
  for (Index v = 0; v < m.cloth_vertex_count; ++v) {
    const std::size_t cloth = at(m.cloth_of_vertex[at(v)]);
    if (cloth >= vertices.size()) vertices.resize(cloth + 1);
    vertices[cloth].push_back(v);
  }
  std::vector<unsigned char> flat;
  for (const std::vector<Index>& v : vertices)
    flat.push_back(!v.empty() && are_flat(m, v, flat_share * thickness) ? 1 : 0);
  return flat;
}

/// Lowers a number that other threads lower too: the smallest wins, in whatever order they come.
void lower(double& own, double to) {
  std::atomic_ref<double> shared(own);
  double now = shared.load(std::memory_order_relaxed);
  while (to < now && !shared.compare_exchange_weak(now, to, std::memory_order_relaxed)) {
  }
}

/// The smallest gap of each vertex.
class StartGaps {
 public:
  /// @param flat [cloths] see flat_cloths()
  StartGaps(const Model& model, double thickness, std::vector<unsigned char> flat)
      : m_(model),
        tables_(make_surface_tables(model)),
        thickness_(thickness),
        flat_cloths_(std::move(flat)),
        gaps_(at(model.cloth_vertex_count), thickness),
        shortest_edge_(at(model.cloth_vertex_count), thickness) {
    for (const Edge& edge : model.edges) {
      if (std::max(edge.v[0], edge.v[1]) >= model.cloth_vertex_count) continue;
      const double l =
          std::sqrt(length_sq(model.positions[at(edge.v[1])] - model.positions[at(edge.v[0])]));
      for (const Index v : edge.v) shortest_edge_[at(v)] = std::min(shortest_edge_[at(v)], l);
    }
  }

  const std::vector<double>& gaps() const { return gaps_; }  ///< [cloth vertices] [m]

  /// Looks at the vertices of each triangle against the face of the other, and at their edges. The
  /// first triangle at a vertex or an edge stands for it. Threads may call it at the same time.
  void look(Index s, Index t) {
    const Tri& a = m_.triangles[at(s)];
    const Tri& b = m_.triangles[at(t)];
    if (of_one_flat_cloth(a, b)) return;
    if (plainly_apart(corners(a), corners(b), thickness_)) return;
    for (int i = 0; i < 3; ++i) {
      if (tables_.face_of_vertex[at(a.v[i])] == s)
        look_at<1>({{a.v[i], b.v[0], b.v[1], b.v[2]}}, cut_of_face(t));
      if (tables_.face_of_vertex[at(b.v[i])] == t)
        look_at<1>({{b.v[i], a.v[0], a.v[1], a.v[2]}}, cut_of_face(s));
      const Index e = tables_.edges_of_face[at(s)].v[i];
      if (tables_.wings[at(e)].first_face != s) continue;
      for (const Index f : tables_.edges_of_face[at(t)].v)
        if (tables_.wings[at(f)].first_face == t) {
          const Index* of_e = m_.edges[at(e)].v;
          const Index* of_f = m_.edges[at(f)].v;
          look_at<2>({{of_e[0], of_e[1], of_f[0], of_f[1]}}, is_cut(e) | is_cut(f) << 1U);
        }
    }
  }

 private:
  using Corner4 = std::array<Index, 4>;

  bool of_one_flat_cloth(const Tri& a, const Tri& b) const {
    const auto cloth = [&](Index v) {
      return v < m_.cloth_vertex_count ? m_.cloth_of_vertex[at(v)] : Index{-1};
    };
    const Index first = cloth(a.v[0]);
    if (first < 0 || flat_cloths_[at(first)] == 0) return false;
    return cloth(a.v[1]) == first && cloth(a.v[2]) == first && cloth(b.v[0]) == first &&
           cloth(b.v[1]) == first && cloth(b.v[2]) == first;
  }

  Corners corners(const Tri& tri) const {
    return {m_.positions[at(tri.v[0])], m_.positions[at(tri.v[1])], m_.positions[at(tri.v[2])]};
  }

  template <int First>
  static bool farther(const Vec3<double> x[4], double d) {
    if constexpr (First == 1) return vertex_triangle_farther(x, d);
    return edge_edge_farther(x, d);
  }

  unsigned is_cut(Index edge) const {
    return at(edge) < m_.cut.size() ? unsigned{m_.cut[at(edge)]} : 0U;
  }

  unsigned cut_of_face(Index t) const {
    const Index* e = tables_.edges_of_face[at(t)].v;
    return is_cut(e[0]) | is_cut(e[1]) << 1U | is_cut(e[2]) << 2U;
  }

  /// @param cut as in rest_distance_sq()
  template <int First>
  void look_at(const Corner4& v, unsigned cut) {
    Vec3<double> x[4];
    for (std::size_t j = 0; j < 4; ++j) x[j] = m_.positions[at(v[j])];
    if (farther<First>(x, thickness_) || are_joined<First>(v) || are_neighbours<First>(v, cut))
      return;
    const Proximity<double> closest = closest_points<First>(x);
    const double gap = std::sqrt(closest.distance_sq);
    if (!(gap < full_share * thickness_)) return;
    const bool obstacle =
        std::any_of(v.begin(), v.end(), [&](Index i) { return i >= m_.cloth_vertex_count; });
    for (std::size_t j = 0; j < 4; ++j) {
      if (closest.w[j] == 0 || v[j] >= m_.cloth_vertex_count) continue;
      if (obstacle && gap + shortest_edge_[at(v[j])] >= thickness_) continue;
      lower(gaps_[at(v[j])], gap);
    }
  }

  /// Whether the primitives have a vertex in common, or a seam ties them.
  template <int First>
  bool are_joined(const Corner4& v) const {
    for (std::size_t i = 0; i < First; ++i)
      for (std::size_t j = First; j < 4; ++j) {
        if (v[i] == v[j]) return true;
        if (std::max(v[i], v[j]) < m_.cloth_vertex_count && m_.tied[at(v[i])] == m_.tied[at(v[j])])
          return true;
      }
    return false;
  }

  /// Whether CollideProximity limits the repulsion of the pair by its distance at rest.
  template <int First>
  bool are_neighbours(const Corner4& v, unsigned cut) const {
    Index cloth[4];
    Vec3<double> rest[4];
    for (std::size_t j = 0; j < 4; ++j) {
      if (v[j] >= m_.cloth_vertex_count) return false;
      cloth[j] = m_.cloth_of_vertex[at(v[j])];
      const Vec2<double>& u = m_.material_points[at(v[j])];
      rest[j] = {u[0], u[1], 0};
    }
    const double reach_sq = std::pow(thickness_ / rest_share, 2);
    // Corners are no closer than the primitives, and mostly close enough.
    for (int i = 0; i < First; ++i)
      for (int j = First; j < 4; ++j)
        if (cloth[i] == cloth[j] && length_sq(rest[j] - rest[i]) < reach_sq) return true;
    return rest_distance_sq<First>(rest, cloth, cut) < reach_sq;
  }

  const Model& m_;
  SurfaceTables tables_;
  double thickness_;
  std::vector<unsigned char> flat_cloths_;
  std::vector<double> gaps_;
  std::vector<double> shortest_edge_;  ///< [cloth vertices] [m] at most the thickness
};

/// Whether the box of any of the cloth's triangles overlaps another.
/// @param pad [m] it is larger than the triangle by this
bool any_overlaps(const Model& m, double pad, const Aabb& other) {
  const Vec3<double> corner{pad, pad, pad};
  return std::any_of(m.triangles.begin(), m.triangles.begin() + m.cloth_triangle_count,
                     [&](const Tri& t) {
                       Aabb box;
                       for (const Index v : t.v) box.include(m.positions[at(v)]);
                       return other.overlaps({box.lo - corner, box.hi + corner});
                     });
}

}  // namespace

std::vector<double> start_thickness(const Scene& scene, const Model& model) {
  const double thickness = contact_thickness(scene.contact);
  const Span<const Vec3<double>> points(model.positions.data(), model.positions.size());
  const Span<const Tri> triangles(model.triangles.data(), model.triangles.size());
  const Index cloth_end = model.cloth_triangle_count;
  const auto end = static_cast<Index>(triangles.size());
  const std::vector<unsigned char> all_awake(points.size(), 1);
  const auto tree_of = [&](Index first, Index last) {
    BoxTree tree(points, triangles, first, last, 0);
    tree.refit(points, triangles, thickness / 2, {all_awake.data(), all_awake.size()});
    return tree;
  };
  std::vector<unsigned char> flat = flat_cloths(model, thickness);
  const bool self = scene.contact.self && !(flat.size() == 1 && flat[0] != 0);
  std::optional<BoxTree> obstacle;
  if (end > cloth_end) obstacle = tree_of(cloth_end, end);
  if (!self && !(obstacle && any_overlaps(model, thickness / 2, obstacle->nodes[1]))) return {};
  const BoxTree cloth = tree_of(0, cloth_end);
  StartGaps gaps(model, thickness, std::move(flat));
  // As in refuse_intersecting_start(): each node of a level with all that is below it, and the
  // nodes above with their halves against each other.
  const std::size_t level = std::min<std::size_t>(cloth.leaf_count, 256);
  for_each_index(setup_threads(at(cloth_end)), level, [&](std::size_t k) {
    const auto visit = [&](Index s, Index t) { gaps.look(s, t); };
    if (self) visit_own_pairs(cloth, level + k, visit);
    if (self && k > 0) visit_pairs(cloth, 2 * k, cloth, 2 * k + 1, visit);
    if (obstacle) visit_pairs(cloth, level + k, *obstacle, 1, visit);
  });
  std::vector<double> result = gaps.gaps();
  if (std::all_of(result.begin(), result.end(), [&](double gap) { return gap == thickness; }))
    return {};
  for (double& gap : result) gap = std::max(gap, rest_least * thickness);
  return result;
}

}  // namespace weft
