#pragma once

#include <vector>

#include "weft/frame.hpp"
#include "weft/scene.hpp"

// States of one scene whose cloths have other meshes, brought to the same ones in material space.

namespace weft {

/// Meshes of cloths, which their owner keeps. [cloths]
using ClothMeshes = std::vector<const Mesh*>;

/// Those of a scene's cloths. They point into the argument, as do the ones that follow.
ClothMeshes cloth_meshes(const Scene& scene);
/// All of them.
ClothMeshes cloth_meshes(const std::vector<Mesh>& meshes);

/// Meshes of the cloths, to keep.
std::vector<Mesh> copied_meshes(const Scene& scene);

/// Whether they have the same triangles of the same material points.
bool same_meshes(const ClothMeshes& a, const ClothMeshes& b);

/// A frame on other meshes of the same cloths: positions, and velocities where there are any, are
/// linear over the triangles that it was on.
/// @param from meshes that the frame is of   @param to those that it is brought to
/// @return     the frame itself where these are the same
Frame frame_on(const Frame& frame, const ClothMeshes& from, const ClothMeshes& to);

}  // namespace weft
