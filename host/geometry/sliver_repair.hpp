#pragma once

#include <cstddef>

#include "weft/scene.hpp"

namespace weft {

/// What repair_slivers() did.
struct SliverRepair {
  std::size_t collapsed = 0;  ///< short edges that became one vertex
  std::size_t flipped = 0;    ///< long edges that were put across the pair of triangles beside them
  std::size_t dropped = 0;    ///< triangles whose long edge was part of the outline
};

/// Removes triangles whose height over the longest edge is below `least` of that edge, in material
/// space, or in the world if there are no material coordinates. One with a short edge loses that:
/// the vertex on the outline stays, of two the one where the outline turns more, else the lower
/// number. Of the others the longest edge is flipped, or the triangle is dropped if that edge is
/// part of the outline. No triangle turns over, the surface stays manifold, and vertices with
/// several material coordinates stay. What cannot be removed so is left.
/// @param mesh  manifold and consistently oriented; keeps its vertices, some of which have no
///              triangle afterwards
/// @param least [1]
SliverRepair repair_slivers(Mesh& mesh, double least);

}  // namespace weft
