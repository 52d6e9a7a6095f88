#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"
#include "host/io/scene/scene_parts.hpp"

namespace weft::io {

/// One entry of "garments" before the bodies are known.
struct GarmentEntry {
  std::string field;  ///< for messages
  std::string body;   ///< name of an obstacle; empty: none
  Index cloth = 0;    ///< into Scene::cloths
  Garment garment;
};

/// Reads the patterns of "garments" and adds a cloth for each, flat where its panels stand.
/// @param groups gets an entry for each
/// @throws SceneError
std::vector<GarmentEntry> read_garments(Fields& root, const ReadableFolders& folders, Scene& scene,
                                        std::vector<ClothGroup>& groups);

/// Sews garments around their bodies, see relax_start(), and adds their seams.
/// @throws SceneError for a body that is not there
void place_garments(std::vector<GarmentEntry>& garments, Scene& scene);

}  // namespace weft::io
