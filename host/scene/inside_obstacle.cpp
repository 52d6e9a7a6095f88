#include "host/scene/inside_obstacle.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "host/geometry/box_tree.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

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

}  // namespace

std::optional<InsideObstacle> part_inside_obstacle(const Scene& scene, const Surfaces& surfaces,
                                                   std::size_t cloth, const Vec3<double>& offset) {
  const std::size_t cloths = scene.cloths.size();
  const Mesh& mesh = scene.cloths[cloth].mesh;
  const std::vector<Index> probes = one_vertex_a_part(mesh);
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    if (!is_closed(scene.obstacles[o].mesh)) continue;
    Aabb around;
    for (Index v = surfaces.first_point[cloths + o]; v < surfaces.first_point[cloths + o + 1]; ++v)
      around.include(surfaces.points[at(v)], surfaces.points[at(v)]);
    for (const Index v : probes) {
      const Vec3<double> x = mesh.positions[at(v)] + offset;
      if (!around.overlaps({x, x})) continue;
      if (winding_number(surfaces, surfaces.first_triangle[cloths + o],
                         surfaces.first_triangle[cloths + o + 1], x) > 0.5)
        return InsideObstacle{o, v};
    }
  }
  return std::nullopt;
}

}  // namespace weft
