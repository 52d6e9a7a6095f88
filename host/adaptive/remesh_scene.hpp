#pragma once

#include <vector>

#include "host/adaptive/remesh_parts.hpp"
#include "host/scene/sewing.hpp"
#include "weft/scene.hpp"

namespace weft {

struct ViewField;

/// The state of a scene's cloths by input numbers, see input_offsets().
struct InputState {
  std::vector<Vec3<double>> positions;              ///< [inputs] [m]
  std::vector<Vec3<double>> velocities;             ///< [inputs] [m/s]
  std::vector<Vec3<double>> previous_velocities{};  ///< [inputs] [m/s] a step ago; empty: not told
};

/// Outcome of remeshing the cloths of a scene. Without a change all but the counts is empty.
struct SceneRemesh {
  RemeshCounts counts;
  InputState state;                 ///< of the new inputs
  std::vector<Index> input_before;  ///< [new inputs] number that it had; -1: it is new
  std::vector<unsigned char> kept;  ///< [new inputs] see named_inputs()

  bool changed() const { return counts.splits + counts.flips + counts.collapses > 0; }
};

/// Vertices that pins, handles and seams name: these are never removed.
/// @return [inputs] 1 or 0
std::vector<unsigned char> named_inputs(const Scene& scene);

/// Settings with the sizes that are left to the mesh filled in: an adaptive mesh is at most as fine
/// as the given one, and up to eight times as coarse.
Remeshing remeshing_of(const Scene& scene, const Cloth& cloth);

/// Brings every cloth of the scene to its sizing field. Replaces meshes, materials of triangles,
/// and the vertices that pins, handles and seams name. Vertices keep their order; new ones come
/// last. Those between two that a pin holds are held by it too.
/// @param kept    [inputs] 1: never removed
/// @param budget  with the laws of the scene's materials
/// @param joined  [inputs] see joined_inputs()
/// @param around  obstacles, as they are now
/// @param view    of the scene's triangles, one cloth after the other; null: none
SceneRemesh remesh_scene(Scene& scene, const std::vector<Index>& joined,
                         const std::vector<unsigned char>& kept, InputState state,
                         const Surroundings& around, const EnergyBudget& budget,
                         const ViewField* view = nullptr);

}  // namespace weft
