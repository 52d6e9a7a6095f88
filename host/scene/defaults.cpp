#include "host/scene/defaults.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/scene/fabric/fabrics.hpp"
#include "weft/core/at.hpp"

namespace weft {

double mean_cell_edge(const std::vector<Cloth>& cloths) {
  double twice_area = 0;
  std::size_t count = 0;
  for (const Cloth& cloth : cloths) {
    const auto exists = [&](Index v) { return v >= 0 && at(v) < cloth.mesh.positions.size(); };
    for (const Tri& tri : cloth.mesh.triangles) {
      if (!std::all_of(tri.v, tri.v + 3, exists)) continue;
      ++count;
      const Vec3<double>& a = cloth.mesh.positions[at(tri.v[0])];
      const Vec3<double>& b = cloth.mesh.positions[at(tri.v[1])];
      const Vec3<double>& c = cloth.mesh.positions[at(tri.v[2])];
      twice_area += length(cross(b - a, c - a));
    }
  }
  return std::sqrt(twice_area / static_cast<double>(count));
}

double thickness_of(const Scene& scene) {
  if (scene.contact.thickness) return *scene.contact.thickness;
  const double usual = contact_thickness(scene.contact);
  // A thickness near the cell size would have a flat cloth repel itself.
  const double edge = mean_cell_edge(scene.cloths);
  return edge > 0 ? std::min(usual, edge / 4) : usual;
}

bool takes_default_fabric(const Scene& scene) {
  const auto names_none = [](const Cloth& cloth) {
    return cloth.material == 0 && cloth.triangle_material.empty();
  };
  return scene.materials.empty() &&
         std::all_of(scene.cloths.begin(), scene.cloths.end(), names_none);
}

void fill_in_defaults(Scene& scene) {
  if (takes_default_fabric(scene)) scene.materials.push_back(fabric(default_fabric));
  scene.contact.thickness = thickness_of(scene);
  for (Seam& seam : scene.seams)
    if (!seam.weld_distance) seam.weld_distance = scene.contact.thickness;
}

}  // namespace weft
