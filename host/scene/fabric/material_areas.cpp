#include "host/scene/fabric/material_areas.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft {

double material_area(const Mesh& mesh, std::size_t triangle) {
  const Tri& tri = mesh.material_triangles.empty() ? mesh.triangles[triangle]
                                                   : mesh.material_triangles[triangle];
  const auto at = [&](int k) { return mesh.material[static_cast<std::size_t>(tri.v[k])]; };
  const Vec2<double> a = at(1) - at(0);
  const Vec2<double> b = at(2) - at(0);
  return std::abs(a[0] * b[1] - a[1] * b[0]) / 2;
}

std::vector<MaterialAreas> areas_by_material(const Scene& scene) {
  std::vector<MaterialAreas> areas(scene.materials.size());
  for (const Cloth& cloth : scene.cloths)
    for (std::size_t t = 0; t < cloth.mesh.triangles.size(); ++t) {
      const Index material =
          cloth.triangle_material.empty() ? cloth.material : cloth.triangle_material[t];
      MaterialAreas& of = areas[static_cast<std::size_t>(material)];
      const double area = material_area(cloth.mesh, t);
      of.least = std::min(of.least, area);
      of.sum += area;
      ++of.count;
    }
  return areas;
}

}  // namespace weft
