#pragma once

#include <vector>

#include "host/io/mesh/mesh_file.hpp"

/// Numbers that a frame can be coloured by, one for each corner of each cloth's triangles; not a
/// number where there is none.
namespace weft::io {

/// [cloth][3 * triangles]
using CornerValues = std::vector<std::vector<float>>;

/// Largest principal stretch of each triangle, less 1: negative only if it is compressed in every
/// direction. Not a number without material coordinates.
/// @pre corners and material corners are in range
CornerValues strain_values(const std::vector<NamedMesh>& cloths);

/// Height above z = 0 [m] at each corner.
/// @pre corners are in range
CornerValues height_values(const std::vector<NamedMesh>& cloths);

/// Distance of each vertex to the nearest other surface, cloth or obstacle, over `thickness`; what
/// is farther than `reach` thicknesses counts as `reach`. Of its own cloth, triangles do not count
/// that hold the vertex, or that are nearer than 1.5 `reach` thicknesses to it in the material.
/// @param thickness [m] > 0
/// @pre corners are in range
/// @throws DeviceError if Embree cannot start
CornerValues contact_values(const std::vector<NamedMesh>& cloths,
                            const std::vector<NamedMesh>& obstacles, double thickness,
                            double reach);

}  // namespace weft::io
