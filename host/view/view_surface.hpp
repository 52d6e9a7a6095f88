#pragma once

#include <array>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// What a camera looks at: the triangles of all cloths, and those of obstacles.
struct ViewSurface {
  std::vector<Tri> triangles;
  std::vector<std::array<Index, 3>> across;  ///< [triangles] the one behind each edge; -1: none
  std::vector<Tri> obstacles;
};

/// Where its vertices stand at one instant.
struct ViewPlaces {
  std::vector<Vec3<double>> cloth;      ///< [m]
  std::vector<Vec3<double>> obstacles;  ///< [m]
};

/// @param triangles of all cloths; where more than two share an edge, none is across it
ViewSurface make_view_surface(std::vector<Tri> triangles, std::vector<Tri> obstacles);

}  // namespace weft
