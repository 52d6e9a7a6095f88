#pragma once

#include <array>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Two triangles that get the same three corners once all seams are welded, so that they would lie
/// on each other.
struct StackedTriangles {
  std::array<Index, 2> cloth;
  std::array<Index, 2> triangle;
};

/// @pre the vertices of all seams exist
std::vector<StackedTriangles> stacked_triangles(const Scene& scene);

}  // namespace weft
