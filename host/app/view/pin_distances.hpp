#pragma once

#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// How far pinned vertices are from the places that their pins prescribe. Pins that follow an
/// obstacle are left out, and so are pins that have let go.
/// @param cloths in world positions, as a frame has them
/// @param time   [s] of the frame
/// @return [m] by cloth and vertex, NaN where no pin holds; empty if there is none, or if the
/// cloths
///         are not the meshes of the scene, as after remeshing
std::vector<std::vector<float>> pin_distances(const Scene& scene,
                                              const std::vector<io::NamedMesh>& cloths,
                                              double time);

}  // namespace weft::app
