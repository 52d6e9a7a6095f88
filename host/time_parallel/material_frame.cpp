#include "host/time_parallel/material_frame.hpp"

#include <algorithm>
#include <cstddef>

#include "host/time_parallel/material_map.hpp"

namespace weft {
namespace {

bool same_triangles(const std::vector<Tri>& a, const std::vector<Tri>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Tri& t, const Tri& u) { return std::equal(t.v, t.v + 3, u.v); });
}

}  // namespace

ClothMeshes cloth_meshes(const Scene& scene) {
  ClothMeshes meshes;
  for (const Cloth& cloth : scene.cloths) meshes.push_back(&cloth.mesh);
  return meshes;
}

ClothMeshes cloth_meshes(const std::vector<Mesh>& meshes) {
  ClothMeshes result;
  for (const Mesh& mesh : meshes) result.push_back(&mesh);
  return result;
}

std::vector<Mesh> copied_meshes(const Scene& scene) {
  std::vector<Mesh> meshes;
  for (const Cloth& cloth : scene.cloths) meshes.push_back(cloth.mesh);
  return meshes;
}

bool same_meshes(const ClothMeshes& a, const ClothMeshes& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Mesh* one, const Mesh* other) {
    return one == other ||
           (same_triangles(one->triangles, other->triangles) && one->material == other->material &&
            same_triangles(one->material_triangles, other->material_triangles));
  });
}

Frame frame_on(const Frame& frame, const ClothMeshes& from, const ClothMeshes& to) {
  if (same_meshes(from, to)) return frame;
  Frame result = frame;
  for (std::size_t c = 0; c < to.size(); ++c) {
    const MaterialMap map = map_material(*to[c], *from[c]);
    result.cloth_positions[c] = interpolated(map, frame.cloth_positions[c].data());
    if (c < frame.cloth_velocities.size())
      result.cloth_velocities[c] = interpolated(map, frame.cloth_velocities[c].data());
  }
  return result;
}

}  // namespace weft
