#pragma once

#include <vector>

#include "host/adaptive/remesh_parts.hpp"
#include "host/scene/seams/sewing.hpp"
#include "weft/scene.hpp"

namespace weft {

struct ViewField;

/// The state of a scene's cloths in input order, see input_offsets().
struct InputState {
  std::vector<Vec3<double>> positions;              ///< [inputs] [m]
  std::vector<Vec3<double>> velocities;             ///< [inputs] [m/s]
  std::vector<Vec3<double>> previous_velocities{};  ///< [inputs] [m/s] one step ago; empty: unknown
};

/// Result of remeshing the cloths of a scene. If nothing changed, only the counts are set.
struct SceneRemesh {
  RemeshCounts counts;
  Scene scene{};                      ///< with the new meshes
  InputState state{};                 ///< of the new inputs
  std::vector<Index> input_before{};  ///< [new inputs] number before the remesh; -1: a new vertex
  std::vector<unsigned char> kept{};  ///< [new inputs] see named_inputs()

  bool changed() const { return counts.splits + counts.flips + counts.collapses > 0; }
};

/// The vertices that pins, handles and seams name. Remeshing never removes them, but for those
/// within a straight edge of the outline that a pin of three or more vertices holds.
/// @return [inputs] Keeping
std::vector<unsigned char> named_inputs(const Scene& scene);

/// Settings of a cloth. Sizes that the scene does not give come from the mesh: the adaptive mesh is
/// then at most as fine as the given one, and up to eight times as coarse.
Remeshing remeshing_of(const Scene& scene, const Cloth& cloth);

/// Adapts every cloth of a scene to its sizing field. The new scene has other meshes, materials of
/// triangles, and the vertices that pins, handles and seams name. Vertices keep their order; new
/// ones come last. A new vertex between two vertices of one pin is held by that pin too, if the pin
/// has three or more vertices.
/// @param kept    [inputs] Keeping
/// @param budget  includes the laws of the scene's materials
/// @param joined  [inputs] see joined_inputs()
/// @param around  obstacles, as they are now
/// @param view    for the scene's triangles, one cloth after the other; null: none
SceneRemesh remesh_scene(const Scene& scene, const std::vector<Index>& joined,
                         const std::vector<unsigned char>& kept, InputState state,
                         const Surroundings& around, const EnergyBudget& budget,
                         const ViewField* view = nullptr);

}  // namespace weft
