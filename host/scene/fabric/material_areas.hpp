#pragma once

#include <limits>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Triangles of one material at rest.
struct MaterialAreas {
  double least = std::numeric_limits<double>::infinity();  ///< [m^2] of one triangle
  double sum = 0;                                          ///< [m^2]
  double count = 0;
};

/// @return area of a triangle at rest [m^2]
double material_area(const Mesh& mesh, std::size_t triangle);

/// @return [materials]
std::vector<MaterialAreas> areas_by_material(const Scene& scene);

}  // namespace weft
