#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"
#include "host/io/scene/scene_parts.hpp"

namespace weft::io {

/// Edges of a garment that springs hold.
struct Attachment {
  Handle handle;
  /// [m] along Handle::along; empty: the mean of where the vertices start
  std::optional<double> place{};
};

/// A cloth of "garments" that is not sewn yet.
struct GarmentCloth {
  Index cloth = 0;     ///< into Scene::cloths
  double edge = 0;     ///< [m]
  int layer = 0;       ///< worn over garments of lower layers
  std::string file{};  ///< of the pattern
  Garment garment{};
  SewnStart start = SewnStart::automatic;
  std::vector<Attachment> attachments{};
};

/// Reads the patterns of "garments" and adds a cloth for each, flat where its panels stand.
/// @param groups gets an entry for each
/// @throws SceneError
std::vector<GarmentCloth> read_garments(Fields& root, const ReadableFolders& folders, Scene& scene,
                                        std::vector<ClothGroup>& groups);

/// Sews garments outside of the obstacles, see relax_start(), and adds their seams to those of the
/// scene. After contact, whose thickness they need, and the obstacles.
void sew_garments(std::vector<GarmentCloth>& garments, Scene& scene);

/// Adds the attachments of garments that are sewn to the handles of the scene, behind those that it
/// names.
void attach_garments(const std::vector<GarmentCloth>& garments, Scene& scene);

}  // namespace weft::io
