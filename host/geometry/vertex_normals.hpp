#pragma once

#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Unit normals at the vertices: means of the triangles around each, weighted by area. Summed in
/// the order of the triangles; the scale of the mesh does not matter.
/// @return [positions]; (0, 0, 1) where no triangle says otherwise
/// @pre the corners are in range
std::vector<Vec3<float>> vertex_normals(const Mesh& mesh);

}  // namespace weft
