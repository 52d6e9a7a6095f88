#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/adaptive/remesh_scene.hpp"
#include "host/state/store.hpp"
#include "host/view/scene_view.hpp"

namespace weft {

/// What an adaptive run carries from remesh to remesh, beside its scene.
struct AdaptiveRun {
  std::vector<unsigned char> kept;  ///< [inputs] Keeping
  double peak_kinetic = 0;          ///< [J] the largest energy of motion at the end of a frame
  /// [cloth triangles] as the scene numbers them, see Store::set_compression(); empty: 1
  std::vector<double> compression;
  std::uint64_t origin = 0;  ///< says which scene the meshes come from
};

/// Fills in what a scene leaves to its meshes, and starts to adapt them.
AdaptiveRun begin_adaptive(Scene& scene);

/// Remeshes the cloths of a scene in the state that the store has.
/// @param tries remeshes of this state whose change of energy was too large: 0 or 1. What splits
///              may add is bounded then
template <class T>
SceneRemesh remesh_run(const Scene& scene, const std::vector<unsigned char>& welded,
                       const AdaptiveRun& run, const Store<T>& store, int tries);

/// Change of energy that a remesh may leave; infinity at the start. [J]
/// 5 times what flips and collapses alone may make: AdaptiveSettings::energy_share, by default 1 %
/// of the largest kinetic energy.
double largest_jump(const Scene& scene, const Model& model, const AdaptiveRun& run,
                    std::int64_t step_number);

/// What flips and collapses may change the energy by, AdaptiveSettings::energy_share; infinity at
/// the start. [J]
double allowed_joules(const Scene& scene, const Model& model, const AdaptiveRun& run,
                      std::int64_t step_number);

/// What a scene's camera sees of the state that the store has: how its cloths yield to compression
/// until the next remesh, which the run keeps and the store is given.
/// @param joules most that elastic energy may grow by because cloth yields less than the run says;
///               what would grow it more yields less only gradually. Infinity: no limit [J]
/// @pre the method is "view"
template <class T>
SceneView validate_run(const Scene& scene, AdaptiveRun& run, Store<T>& store, double joules);

/// The state after a remesh: positions and velocities are its, what contacts leave to the next step
/// is kept where all of their vertices are. Starts without history.
/// @param to the model after
template <class T>
StateSnapshot<T> remeshed_state(const Model& from, const StateSnapshot<T>& state,
                                const SceneRemesh& remesh, const Model& to);

/// Energy of motion of the velocity that is linear over every triangle. Splits leave it as it is,
/// which cannot be said of the sum over vertices. [J]
template <class T>
double surface_kinetic(const Scene& scene, const Model& model,
                       const std::vector<Vec3<T>>& velocities);

/// Takes energy that a remesh has added out of the motion around the vertices that it has put in,
/// of each cloth relative to the mean: momentum stays. A kink between coarse facets costs more
/// bending energy where triangles are smaller, and would shake the cloth.
/// @param added [J]   @param state its velocities change
/// @return [J] what has been taken, at most `added`; the rest is not there
template <class T>
double pay_from_motion(const Scene& scene, const Model& model, const SceneRemesh& remesh,
                       double added, StateSnapshot<T>& state);

/// Meshes, and what names their vertices, as bytes for a checkpoint.
std::string adaptive_bytes(const Scene& scene, const AdaptiveRun& run);

/// Gives a scene the meshes of a checkpoint.
/// @param file for messages
/// @throws SceneError if the bytes make no sense, or belong to another scene
void read_adaptive_bytes(const std::string& bytes, const std::string& file, Scene& scene,
                         AdaptiveRun& run);

}  // namespace weft
