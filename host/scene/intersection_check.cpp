#include "host/scene/intersection_check.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/parallel.hpp"
#include "host/geometry/box_tree.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "host/scene/surfaces.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

// ---- what to say

/// Counts pairs of triangles and keeps the lowest few.
class FoundPairs {
 public:
  void add(Index a, Index b) {
    ++count_;
    lowest_.emplace_back(std::min(a, b), std::max(a, b));
    std::sort(lowest_.begin(), lowest_.end());
    if (lowest_.size() > shown_max) lowest_.pop_back();
  }
  void add(const FoundPairs& more) {
    count_ += more.count_;
    lowest_.insert(lowest_.end(), more.lowest_.begin(), more.lowest_.end());
    std::sort(lowest_.begin(), lowest_.end());
    if (lowest_.size() > shown_max) lowest_.resize(shown_max);
  }
  void refuse_any(const Scene& scene, const Surfaces& surfaces, const std::string& note) const {
    if (count_ == 0) return;
    std::string list;
    for (const auto& [a, b] : lowest_) {
      const std::size_t s = surfaces.mesh_of(a);
      const std::size_t t = surfaces.mesh_of(b);
      list += list.empty() ? "triangles " : ", ";
      list += std::to_string(a - surfaces.first_triangle[s]);
      if (s != t) list += " of " + name_of(scene, s);
      list += " and " + std::to_string(b - surfaces.first_triangle[t]) + " of " + name_of(scene, t);
    }
    throw SceneError(
        scene.file, title_of(scene, surfaces.mesh_of(lowest_.front().first)),
        list + " intersect, " + std::to_string(count_) +
            (count_ == 1 ? " pair in all" : " pairs in all") + note,
        std::string("a start free of intersections, touching included") +
            (scene.contact.untangle ? "" : ", or contact.untangle true, which moves cloth apart"));
  }

 private:
  static constexpr std::size_t shown_max = 4;
  std::int64_t count_ = 0;
  std::vector<std::pair<Index, Index>> lowest_;
};

void refuse_intersections(const Scene& scene, const Surfaces& surfaces, const std::string& note) {
  const Index cloth_end = surfaces.first_triangle[scene.cloths.size()];
  const BoxTree cloth(surfaces.points, surfaces.triangles, 0, cloth_end, touching);
  std::optional<BoxTree> obstacle;
  if (!scene.obstacles.empty())
    obstacle.emplace(surfaces.points, surfaces.triangles, cloth_end, surfaces.first_triangle.back(),
                     touching);
  // Of the nodes of a level all that is below, and all of it against obstacles; of those above, as
  // many but one, only their halves against each other.
  const std::size_t level = std::min<std::size_t>(cloth.leaf_count, 256);
  std::vector<FoundPairs> found(level);
  for_each_index(setup_threads(at(cloth_end)), level, [&](std::size_t k) {
    const auto visit = [&](Index a, Index b) {
      if (triangles_intersect(surfaces.triangles[at(a)], surfaces.triangles[at(b)],
                              surfaces.corners(a), surfaces.corners(b)))
        found[k].add(a, b);
    };
    if (scene.contact.self) visit_own_pairs(cloth, level + k, visit);
    if (scene.contact.self && k > 0) visit_pairs(cloth, 2 * k, cloth, 2 * k + 1, visit);
    if (obstacle) visit_pairs(cloth, level + k, *obstacle, 1, visit);
  });
  FoundPairs all;
  for (const FoundPairs& some : found) all.add(some);
  all.refuse_any(scene, surfaces, note);
}

// ---- inside an obstacle

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

void refuse_intersecting_start(const Scene& scene, const std::vector<unsigned char>& welded,
                               const std::string& note) {
  const Surfaces surfaces = surfaces_at_start(scene, welded);
  refuse_intersections(scene, surfaces, note);
  refuse_inside_obstacles(scene, surfaces);
}

}  // namespace weft
