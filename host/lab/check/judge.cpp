#include "host/lab/check/judge.hpp"

#include <string>

#include "host/lab/check/intersections.hpp"
#include "host/lab/check/quality.hpp"
#include "weft/error.hpp"

namespace weft::lab {
namespace {

void require_consistent(const Mesh& mesh, const std::string& name) {
  const std::size_t vertices = mesh.positions.size();
  if (!mesh.material.empty() && mesh.material.size() != vertices)
    throw SceneError("", name + ".material", std::to_string(mesh.material.size()) + " entries",
                     "none, or one a vertex (" + std::to_string(vertices) + ")");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const Index v : mesh.triangles[i].v)
      if (v < 0 || static_cast<std::size_t>(v) >= vertices)
        throw SceneError("", name + ".triangles[" + std::to_string(i) + "]", std::to_string(v),
                         "0 to " + std::to_string(vertices) + " - 1, the vertices of the mesh");
}

}  // namespace

bool FrameVerdict::clean() const {
  return cloth_cloth_count == 0 && cloth_obstacle_count == 0 && inverted.count == 0 &&
         degenerate.count == 0 && nonfinite.count == 0 && nonfinite_obstacle.count == 0;
}

FrameVerdict judge(const Mesh& cloth, const Mesh* obstacle, const JudgeOptions& options) {
  if (!options.obstacle) obstacle = nullptr;
  require_consistent(cloth, "cloth");
  if (obstacle) require_consistent(*obstacle, "obstacle");

  FrameVerdict verdict;
  const std::size_t limit = options.list_limit;
  verdict.triangle_count = static_cast<std::int64_t>(cloth.triangles.size());
  verdict.nonfinite = nonfinite_vertices(cloth.positions, cloth.material, limit);
  const std::vector<Index> ids = finite_triangles(cloth);
  std::vector<Index> obstacle_ids;
  if (obstacle) {
    verdict.obstacle_triangle_count = static_cast<std::int64_t>(obstacle->triangles.size());
    verdict.nonfinite_obstacle = nonfinite_vertices(obstacle->positions, {}, limit);
    obstacle_ids = finite_triangles(*obstacle);
  }
  find_intersections(cloth, ids, obstacle, obstacle_ids, options, verdict);
  verdict.inverted = inverted_triangles(cloth, ids, limit);
  verdict.degenerate = degenerate_triangles(cloth, ids, limit);
  verdict.strain = measure_strain(cloth, ids);
  return verdict;
}

}  // namespace weft::lab
