#include "host/lab/check/validator.hpp"

#include <array>
#include <cmath>
#include <map>
#include <string>

#include "host/lab/check/intersections.hpp"
#include "host/lab/check/quality.hpp"
#include "weft/error.hpp"

namespace weft::lab {
namespace {

/// The corners that a mesh has of its own in material space, if any.
void require_material_corners(const Mesh& mesh, const std::string& name) {
  if (mesh.material_triangles.size() != mesh.triangles.size())
    throw SceneError("", name + ".material_triangles",
                     std::to_string(mesh.material_triangles.size()) + " entries",
                     "none, or one a triangle (" + std::to_string(mesh.triangles.size()) + ")");
  for (std::size_t i = 0; i < mesh.material_triangles.size(); ++i)
    for (const Index v : mesh.material_triangles[i].v)
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.material.size())
        throw SceneError("", name + ".material_triangles[" + std::to_string(i) + "]",
                         std::to_string(v), "a number of a material coordinate");
}

void require_consistent(const Mesh& mesh, const std::string& name) {
  const std::size_t vertices = mesh.positions.size();
  const bool own_corners = !mesh.material_triangles.empty();
  if (own_corners) require_material_corners(mesh, name);
  if (!own_corners && !mesh.material.empty() && mesh.material.size() != vertices)
    throw SceneError("", name + ".material", std::to_string(mesh.material.size()) + " entries",
                     "none, or one a vertex (" + std::to_string(vertices) + ")");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const Index v : mesh.triangles[i].v)
      if (v < 0 || static_cast<std::size_t>(v) >= vertices)
        throw SceneError("", name + ".triangles[" + std::to_string(i) + "]", std::to_string(v),
                         "0 to " + std::to_string(vertices) + " - 1, the vertices of the mesh");
}

/// The cloth with one number for all vertices at one place.
Mesh joined_where_equal(const Mesh& cloth) {
  const auto place = [&](Index v) {
    const Vec3<double>& x = cloth.positions[static_cast<std::size_t>(v)];
    return std::array<double, 3>{x[0], x[1], x[2]};
  };
  std::map<std::array<double, 3>, Index> first;
  Mesh joined;
  joined.positions = cloth.positions;
  joined.triangles = cloth.triangles;
  for (Tri& t : joined.triangles)
    for (Index& v : t.v) {
      const auto x = place(v);
      if (!std::isnan(x[0] + x[1] + x[2])) v = first.try_emplace(x, v).first->second;
    }
  return joined;
}

}  // namespace

bool FrameVerdict::clean() const {
  return cloth_cloth_count == 0 && cloth_obstacle_count == 0 && inverted.count == 0 &&
         degenerate.count == 0 && nonfinite.count == 0 && nonfinite_obstacle.count == 0;
}

FrameVerdict validate(const Mesh& cloth, const Mesh* obstacle, const ValidatorOptions& options) {
  if (!options.obstacle) obstacle = nullptr;
  require_consistent(cloth, "cloth");
  if (obstacle) require_consistent(*obstacle, "obstacle");

  FrameVerdict verdict;
  const std::size_t limit = options.list_limit;
  verdict.triangle_count = static_cast<std::int64_t>(cloth.triangles.size());
  // Where material coordinates belong to corners there is no vertex to name.
  const bool by_vertex = cloth.material_triangles.empty();
  verdict.nonfinite = nonfinite_vertices(
      cloth.positions, by_vertex ? cloth.material : std::vector<Vec2<double>>(), limit);
  const std::vector<Index> ids = finite_triangles(cloth);
  std::vector<Index> obstacle_ids;
  if (obstacle) {
    verdict.obstacle_triangle_count = static_cast<std::int64_t>(obstacle->triangles.size());
    verdict.nonfinite_obstacle = nonfinite_vertices(obstacle->positions, {}, limit);
    obstacle_ids = finite_triangles(*obstacle);
  }
  if (options.sewn)
    find_intersections(joined_where_equal(cloth), ids, obstacle, obstacle_ids, options, verdict);
  else
    find_intersections(cloth, ids, obstacle, obstacle_ids, options, verdict);
  verdict.inverted = inverted_triangles(cloth, ids, limit);
  verdict.degenerate = degenerate_triangles(cloth, ids, limit);
  verdict.strain = measure_strain(cloth, ids);
  return verdict;
}

}  // namespace weft::lab
