#pragma once

#include <array>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "host/render/picture.hpp"
#include "host/render/picture_values.hpp"
#include "host/render/png_file.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// View factors of a frame's triangles, as the method "view" has them for its meshes; where
/// obstacles will be is left out, however the scene has it.
/// @param scene  with a camera
/// @param time   [s]
io::CornerValues view_factor_values(const io::FrameMeshes& meshes, const Scene& scene, double time);

/// The pyramid that a camera sees, as lines: from its eye along the four edges, and around the
/// picture at their ends.
/// @param camera with keys
/// @param time   [s]
/// @param reach  [m] point that the pyramid is as deep as
std::vector<io::Wire> frustum_wires(const Camera& camera, double time, const Vec3<double>& reach);

/// Two pictures of one size side by side, with a white line between them.
io::Image beside(const io::Image& left, const io::Image& right);

/// Width of two such pictures. [pixels]
int beside_width(int width);

}  // namespace weft::app
