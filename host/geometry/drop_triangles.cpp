#include "host/geometry/drop_triangles.hpp"

namespace weft {

std::size_t drop_triangles(Mesh& mesh, const std::vector<bool>& marked) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < marked.size(); ++t) {
    if (marked[t]) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    if (!mesh.material_triangles.empty())
      mesh.material_triangles[kept] = mesh.material_triangles[t];
    if (!mesh.group.empty()) mesh.group[kept] = mesh.group[t];
    if (!mesh.part.empty()) mesh.part[kept] = mesh.part[t];
    ++kept;
  }
  mesh.triangles.resize(kept);
  if (!mesh.material_triangles.empty()) mesh.material_triangles.resize(kept);
  if (!mesh.group.empty()) mesh.group.resize(kept);
  if (!mesh.part.empty()) mesh.part.resize(kept);
  return marked.size() - kept;
}

}  // namespace weft
