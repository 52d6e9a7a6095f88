#pragma once

#include "host/io/mesh/mesh_file.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// Takes apart what frame files hold as one mesh, so that each cloth and each obstacle stands for
/// itself: by the vertex counts of the scene and with its names where these fit, otherwise by the
/// objects that a file names, otherwise each connected component of cloth is a cloth. Meshes that
/// already stand for themselves stay as they are.
/// @param scene of the run; null: not known
io::FrameMeshes parted(io::FrameMeshes meshes, const Scene* scene);

}  // namespace weft::app
