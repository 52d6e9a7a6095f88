#pragma once

#include <cstdint>
#include <vector>

#include "host/adaptive/remesh_scene.hpp"
#include "host/model/model.hpp"
#include "host/state/store.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "weft/scene.hpp"

// The state that the coarse run gives for a step of the fine one, before detail is recovered.

namespace weft {

/// Where and when a slice starts.
struct StartTime {
  explicit StartTime(const Scene& fine, std::int64_t first_step);

  std::int64_t step;   ///< first of the slice, >= 1
  double length;       ///< [s] of a step
  double now, before;  ///< [s] at that step, and one before
};

/// The scene as if it began at `time`, with cloth and obstacles in other places: for what finds and
/// parts intersecting starts.
/// @param places [inputs] [m]   @param obstacles [obstacle vertices] [m]
Scene scene_at(const Scene& fine, double time, const std::vector<Vec3<double>>& places,
               const std::vector<Vec3<double>>& obstacles);

struct PlacedState {
  InputState cloth;
  std::vector<Vec3<double>> obstacles;  ///< [obstacle vertices] [m]
  double untangled = 0;                 ///< [m] farthest that a vertex was moved to part cloth
};

/// The coarse state on fine meshes, with pins and bodies in their prescribed places and no
/// intersections.
/// @param model of the scene, whose meshes are those that `states` are for
/// @throws SimulationError if what intersects cannot be parted
PlacedState placed_state(const Scene& fine, const Model& model, CoarseStates& states,
                         const StartTime& start);

/// A state that a slice may start in: without history.
template <class T>
StateSnapshot<T> without_history(StateSnapshot<T> state, const StartTime& start);

/// The placed state as a store of `fine` holds it, without history.
/// @param store whose model is that of the placed state
template <class T>
StateSnapshot<T> snapshot_of(const Store<T>& store, const PlacedState& placed,
                             const StartTime& start);

}  // namespace weft
