#pragma once

#include <array>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// A mesh with every triangle split into four at the midpoints of its edges.
struct RefinedMesh {
  Mesh mesh;
  /// [vertices] the two vertices of the coarse mesh that each lies midway between; coarse vertices
  /// keep their numbers and stand here twice
  std::vector<std::array<Index, 2>> parents;
};

/// Positions and material coordinates of new vertices are means of their parents; groups are
/// inherited. Triangle t becomes 4 t to 4 t + 3, the middle one last.
RefinedMesh refine_mesh(const Mesh& mesh);

/// A scene with all cloths split once.
struct RefinedScene {
  Scene scene;
  /// [inputs of the new scene] the two old input numbers that each lies between
  std::vector<std::array<Index, 2>> parents;
};

/// Splits all cloths of a scene once. Pins and handles also hold the midpoints of edges of which
/// they hold both ends; vertices that seams have welded, and the midpoints between them, are joined
/// by seams that stand for those of the scene. Stiffness, times and distances of seams are lost.
/// @param joined [inputs] see joined_inputs()
RefinedScene refine_cloths(const Scene& scene, const std::vector<Index>& joined);

}  // namespace weft
