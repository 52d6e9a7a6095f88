#pragma once

#include <vector>

#include "host/model/model.hpp"
#include "host/view/view_factor.hpp"

namespace weft {

/// Triangles of the scene's cloths, one cloth after the other, by input numbers, and of its
/// obstacles.
ViewSurface scene_surface(const Scene& scene);

/// What the scene's camera makes of its cloths, and how they yield to compression.
/// @param model only its obstacles count, the meshes of the cloths may be others
/// @param now   cloth by input numbers
/// @param time  [s]
/// @pre the camera has keys
ViewField look_at_scene(const Scene& scene, const Model& model, const ViewSurface& surface,
                        const ViewPlaces& now, double time);

/// What is in view now, and what is not.
struct SceneView {
  std::vector<double> compression;  ///< [cloth triangles], see compression_shares()
  Index in_view = 0;                ///< triangles of view factor 1
  double factor_mean = 0;           ///< by area
};
SceneView evaluate_view(const Scene& scene, const ViewSurface& surface, const ViewPlaces& now,
                        double time);

}  // namespace weft
