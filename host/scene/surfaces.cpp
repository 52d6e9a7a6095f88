#include "host/scene/surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/scene/seams/sewing.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

/// Such as "cloths[0]" and its name; meshes are counted through cloths, then obstacles.
std::pair<std::string, std::string> field_and_name(const Scene& scene, std::size_t mesh) {
  const std::size_t cloths = scene.cloths.size();
  if (mesh < cloths) return {"cloths[" + std::to_string(mesh) + "]", scene.cloths[mesh].name};
  const std::size_t o = mesh - cloths;
  return {"obstacles[" + std::to_string(o) + "]", scene.obstacles[o].name};
}

}  // namespace

void Surfaces::add(const Mesh& mesh) {
  const Index first = first_point.back();
  points.insert(points.end(), mesh.positions.begin(), mesh.positions.end());
  for (const Tri& t : mesh.triangles)
    triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  first_point.push_back(static_cast<Index>(points.size()));
  first_triangle.push_back(static_cast<Index>(triangles.size()));
}

Corners Surfaces::corners(Index t) const {
  const Tri& tri = triangles[at(t)];
  return {points[at(tri.v[0])], points[at(tri.v[1])], points[at(tri.v[2])]};
}

std::size_t Surfaces::mesh_of(Index t) const {
  return static_cast<std::size_t>(
      std::upper_bound(first_triangle.begin(), first_triangle.end(), t) - first_triangle.begin() -
      1);
}

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

std::string name_of(const Scene& scene, std::size_t mesh) {
  const auto [field, name] = field_and_name(scene, mesh);
  return name.empty() ? field : name;
}

std::string title_of(const Scene& scene, std::size_t mesh) {
  const auto [field, name] = field_and_name(scene, mesh);
  return name.empty() ? field : field + " (" + name + ")";
}

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

}  // namespace weft
