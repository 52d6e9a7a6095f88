#pragma once

#include <filesystem>
#include <functional>

#include "host/simulation/remeshing.hpp"
#include "host/time_parallel/coarse_scene.hpp"
#include "host/time_parallel/placed_state.hpp"

namespace weft {

/// The fine meshes on which the whole start of a slice is made where slices remesh (Liang &
/// Lin 2018, section 5.4).
struct FrozenMeshes {
  Scene fine;
  AdaptiveRun run;  ///< what the slice carries from remesh to remesh, as it begins
};

/// Remeshes the fine scene for the state that the coarse run gives at the start of a slice, again
/// and again until few edges change, or a bound. Criteria look at that state on the scene's own
/// meshes, which are first made as fine as the coarse ones where they are coarser. The largest
/// kinetic energy, which bounds what later remeshes may change, is that of the coarse run until
/// there. A pure function of the scene and the coarse states.
/// @tparam T    precision of the run
/// @param fine  with the method of the slices, which remeshes
/// @param level made of it
/// @param states directory of the coarse run
/// @param go_on told the work of each remesh, see remesh_work(); false: end at once
/// @param meshes out
/// @return false: told to stop
/// @throws SceneError if a coarse state is missing or damaged
/// @throws SimulationError if the state intersects and cannot be parted
template <class T>
bool freeze_meshes(const Scene& fine, const CoarseScene& level, const StartTime& start,
                   const std::filesystem::path& states,
                   const std::function<bool(double work)>& go_on, FrozenMeshes& meshes);

}  // namespace weft
