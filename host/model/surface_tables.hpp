#pragma once

#include <vector>

#include "host/model/model.hpp"
#include "weft/state/surface.hpp"

namespace weft {

/// What Surface shows, for a model's cloths and obstacles.
struct SurfaceTables {
  std::vector<EdgeWings> wings;       ///< [edges]
  std::vector<Tri> edges_of_face;     ///< [triangles]
  std::vector<Offset> ring_offset;    ///< [vertices + 1]
  std::vector<Index> ring;            ///< ascending for each vertex
  std::vector<Index> face_of_vertex;  ///< [vertices]
};

/// @pre the model's edges ascend, and are all that its triangles have
SurfaceTables make_surface_tables(const Model& model);

}  // namespace weft
