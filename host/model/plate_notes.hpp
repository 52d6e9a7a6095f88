#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/model/plate_patch.hpp"

namespace weft {

/// What has been found out about a triangle of a mesh whose vertices stay where they are. It holds
/// as long as neither the triangle nor its neighbours change: quadratics that read farther, or
/// across a seam, are not written down.
struct PlateNote {
  /// Of the edge opposite a corner. Holds for two triangles of these versions.
  struct Edge {
    Index other = -1;
    std::uint32_t version = 0, other_version = 0;
    double energy = 0;  ///< [J]
  };

  Index triangle = -1;          ///< its number in the mesh
  std::array<bool, 3> inner{};  ///< which edges have a neighbour there
  std::uint32_t version = 1;    ///< counts how often it or a neighbour has changed
  bool known = false;           ///< whether the next two hold
  Quadratic quadratic;          ///< reads vertices by their numbers in the mesh
  bool weighed = false;         ///< whether the energy holds
  double energy = 0;            ///< [J]
  std::array<Edge, 3> edges;

  void forget() {
    known = weighed = false;
    ++version;
  }
};

/// Notes on the triangles of a patch, whose vertices have numbers of their own there.
struct PatchNotes {
  const std::vector<PlateNote*>& of_triangle;  ///< null: nothing is known, nor to be written down
  const std::vector<Index>& vertex_of;         ///< [vertices of the patch] number in the mesh
  const std::vector<Index>& patch_vertex;      ///< [vertices of the mesh] number in the patch
};

}  // namespace weft
