#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Gives a curved mesh material coordinates in which each triangle has its size and shape: each is
/// laid into the plane at the edge of a neighbour that lies there already, breadth first. A surface
/// that can be unrolled keeps its neighbours; any other is cut along some edges, and its vertices
/// there have several coordinates. Each connected piece begins with its first
/// triangle, whose first coordinate runs along x in the plane of that triangle (y, if it faces
/// along x), and lies beside the pieces before it.
/// @pre the mesh has passed check_mesh(); its triangles have areas
void unfold(Mesh& mesh);

}  // namespace weft
