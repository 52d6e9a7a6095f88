#pragma once

#include <cstddef>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// A mesh that check_mesh() accepts, made of another.
struct ManifoldMesh {
  std::vector<Index> source;  ///< [vertices] number in the mesh that it was made of
  std::vector<Tri> triangles;
  std::size_t dropped = 0;   ///< triangles without area, or there twice
  std::size_t detached = 0;  ///< triangles that got vertices of their own
};

/// Makes a surface manifold and consistently oriented without changing what it looks like, for
/// characters from drawing programs, which seldom are. Triangles without area and all but the first
/// of several with the same corners are left out. A triangle that finds one of its edges taken, in
/// the direction in which it runs along it, gets copies of its vertices. Vertices that no triangle
/// needs are left out.
/// @param positions [m] finite
/// @param triangles corners in `positions`
ManifoldMesh make_manifold(const std::vector<Vec3<double>>& positions,
                           const std::vector<Tri>& triangles);

}  // namespace weft
