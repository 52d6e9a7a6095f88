#include "host/time_parallel/placed_state.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "host/scene/frame_steps.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
StartTime::StartTime(const Scene& fine, std::int64_t first_step)
    : step(first_step),
      length(frame_step_length(fine.time)),
      now(static_cast<double>(step) * length),
      before(static_cast<double>(step - 1) * length) {}

Scene scene_at(const Scene& fine, double time, const std::vector<Vec3<double>>& places,
               const std::vector<Vec3<double>>& obstacles) {
  Scene scene = fine;
  std::size_t input = 0;
  for (Cloth& cloth : scene.cloths)
    for (Vec3<double>& x : cloth.mesh.positions) x = places[input++];
  std::size_t v = 0;
  for (Obstacle& obstacle : scene.obstacles) {
    obstacle.transform = {};
    obstacle.motion.clear();
    obstacle.deformation.reset();
    for (Vec3<double>& x : obstacle.mesh.positions) x = obstacles[v++];
  }
  std::erase_if(scene.pins, [time](const Pin& pin) { return !pin_holds(pin, time); });
  return scene;
}

PlacedState placed_state(const Scene& fine, const Model& model, CoarseStates& states,
                         const StartTime& start) {
  PlacedState placed{states.fine_state(start.now), {}, 0};
  std::vector<Vec3<double>>& places = placed.cloth.positions;
  std::vector<Vec3<double>> obstacles_before;
  place_obstacles(fine, model, start.now, placed.obstacles);
  place_obstacles(fine, model, start.before, obstacles_before);
  for (const auto& p : model.pinned) {
    if (!pin_holds(fine.pins[at(p.pin)], start.now)) continue;
    const auto input = at(model.to_input[at(p.vertex)]);
    places[input] = pinned_position(fine, p, start.now, placed.obstacles);
    placed.cloth.velocities[input] =
        (1 / start.length) *
        (places[input] - pinned_position(fine, p, start.before, obstacles_before));
  }
  Scene clear = scene_at(fine, start.now, places, placed.obstacles);
  try {
    untangle_start(clear, {});
  } catch (const SceneError& error) {
    throw SimulationError("the state that the coarse run gives for step " +
                          std::to_string(start.step) + " cannot be parted: " + error.what());
  }
  std::size_t input = 0;
  for (const Cloth& cloth : clear.cloths)
    for (const Vec3<double>& x : cloth.mesh.positions) {
      placed.untangled = std::max(placed.untangled, length(x - places[input]));
      places[input++] = x;
    }
  return placed;
}

template <class T>
StateSnapshot<T> without_history(StateSnapshot<T> state, const StartTime& start) {
  state.time = start.now;
  state.previous_step = 0;
  state.backoff = {};
  state.step_number = start.step;
  state.previous_positions = state.positions;
  state.previous_velocities = state.velocities;
  std::fill(state.touched.begin(), state.touched.end(), static_cast<unsigned char>(0));
  return state;
}

template <class T>
StateSnapshot<T> snapshot_of(const Store<T>& store, const PlacedState& placed,
                             const StartTime& start) {
  const Model& model = store.model();
  StateSnapshot<T> state = store.snapshot();
  const auto cloth = at(model.cloth_vertex_count);
  for (std::size_t v = 0; v < cloth; ++v) {
    state.positions[v] = vec_cast<T>(placed.cloth.positions[at(model.to_input[v])]);
    state.velocities[v] = vec_cast<T>(placed.cloth.velocities[at(model.to_input[v])]);
  }
  for (std::size_t v = 0; v < placed.obstacles.size(); ++v)
    state.positions[cloth + v] = vec_cast<T>(placed.obstacles[v]);
  return without_history(std::move(state), start);
}

template StateSnapshot<float> without_history(StateSnapshot<float>, const StartTime&);
template StateSnapshot<double> without_history(StateSnapshot<double>, const StartTime&);
template StateSnapshot<float> snapshot_of(const Store<float>&, const PlacedState&,
                                          const StartTime&);
template StateSnapshot<double> snapshot_of(const Store<double>&, const PlacedState&,
                                           const StartTime&);

}  // namespace weft
