#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"
#include "host/io/scene/scene_parts.hpp"

namespace weft::io {

/// A cloth of "garments", and what is to be sewn in it.
struct SewnGarment {
  Index cloth = 0;  ///< into Scene::cloths
  std::vector<GarmentSeam> seams;
};

/// Reads the patterns of "garments" and adds a cloth for each, as relax_start() places it.
/// @param groups gets an entry for each
/// @throws SceneError
std::vector<SewnGarment> read_garments(Fields& root, const ReadableFolders& folders, Scene& scene,
                                       std::vector<ClothGroup>& groups);

/// Adds the seams of garments to those of the scene. After contact, whose thickness they need.
void add_garment_seams(const std::vector<SewnGarment>& garments, Scene& scene);

}  // namespace weft::io
