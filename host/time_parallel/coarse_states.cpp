#include "host/time_parallel/coarse_states.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "host/scene/frame_steps.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/simulation/remeshing.hpp"
#include "host/state/checkpoint.hpp"
#include "host/time_parallel/material_frame.hpp"
#include "weft/core/assert.hpp"

namespace weft {
namespace {

constexpr std::size_t states_kept = 4;

std::vector<Vec3<double>> between(const std::vector<Vec3<double>>& a,
                                  const std::vector<Vec3<double>>& b, double share) {
  std::vector<Vec3<double>> result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = (1 - share) * a[i] + share * b[i];
  return result;
}

InputState between(const InputState& a, const InputState& b, double share) {
  return {between(a.positions, b.positions, share), between(a.velocities, b.velocities, share)};
}

InputState upsampled(const CoarseScene& level, const InputState& coarse) {
  return {upsampled(level, coarse.positions), upsampled(level, coarse.velocities)};
}

double kinetic_energy(const Model& model, const InputState& inputs) {
  double sum = 0;
  for (std::size_t i = 0; i < inputs.velocities.size(); ++i)
    sum += model.mass[static_cast<std::size_t>(model.to_internal[i])] *
           length_sq(inputs.velocities[i]) / 2;
  return sum;
}

}  // namespace

CoarseStates::CoarseStates(const CoarseScene& level, std::filesystem::path directory)
    : directory_(std::move(directory)),
      step_(frame_step_length(level.scene.time)),
      begun_(level),
      fine_(nullptr) {
  if (remeshes(level.scene)) {
    Scene begun = level.scene;
    origin_ = begin_adaptive(begun).origin;
  }
  meshes_ = std::make_shared<Meshes>(Meshes{level, make_model(level.scene)});
}

CoarseStates::CoarseStates(const CoarseScene& level, std::filesystem::path directory,
                           const Scene& fine)
    : CoarseStates(level, std::move(directory)) {
  fine_ = &fine;
  meshes_ = meshes_like(level.scene);
}

/// The level with other coarse meshes, and with the fine ones of this.
std::shared_ptr<const CoarseStates::Meshes> CoarseStates::meshes_like(Scene scene) const {
  WEFT_ASSERT(fine_ != nullptr);
  Meshes meshes{{std::move(scene), {}, {}}, {}};
  CoarseScene& level = meshes.level;
  level.schwarz_offset = input_offsets(level.scene);
  const std::vector<MaterialMap>& maps = begun_.maps;
  for (std::size_t c = 0; c < maps.size(); ++c)
    level.maps.push_back(map_material(fine_->cloths[c].mesh, level.scene.cloths[c].mesh));
  meshes.model = make_model(level.scene);
  return std::make_shared<Meshes>(std::move(meshes));
}

std::filesystem::path CoarseStates::file(const std::filesystem::path& directory,
                                         std::int64_t step) {
  char name[40];
  std::snprintf(name, sizeof name, "state_%06lld.weft", static_cast<long long>(step));
  return directory / name;
}

template <class T>
InputState CoarseStates::read_inputs(std::int64_t step, const Meshes& meshes) const {
  const Model& model = meshes.model;
  StateSnapshot<T> state;
  const auto all = static_cast<std::size_t>(model.vertex_count);
  const auto cloth = static_cast<std::size_t>(model.cloth_vertex_count);
  state.positions.resize(all);
  state.previous_positions.resize(all);
  state.velocities.resize(cloth);
  state.previous_velocities.resize(cloth);
  state.touched.resize(all);
  read_checkpoint(file(directory_, step), meshes.level.scene, model, state);
  InputState inputs;
  for (const Index v : model.to_internal) {
    inputs.positions.push_back(vec_cast<double>(state.positions[static_cast<std::size_t>(v)]));
    inputs.velocities.push_back(vec_cast<double>(state.velocities[static_cast<std::size_t>(v)]));
  }
  return inputs;
}

CoarseStates::Known CoarseStates::read(std::int64_t step) {
  Known known;
  if (remeshes(begun_.scene)) {
    Scene scene = begun_.scene;
    AdaptiveRun run;
    run.origin = origin_;
    read_adaptive_bytes(read_adaptive(file(directory_, step)), file(directory_, step), scene, run);
    known.peak_kinetic = run.peak_kinetic;
    // Meshes change at frames only.
    if (!same_meshes(cloth_meshes(scene), cloth_meshes(meshes_->level.scene)))
      meshes_ = meshes_like(std::move(scene));
  }
  known.meshes = meshes_;
  known.coarse = begun_.scene.precision == Precision::single_precision
                     ? read_inputs<float>(step, *meshes_)
                     : read_inputs<double>(step, *meshes_);
  return known;
}

const CoarseStates::Known& CoarseStates::state(std::int64_t step) {
  const auto found = states_.find(step);
  if (found != states_.end()) return found->second;
  if (states_.size() >= states_kept) states_.erase(states_.begin());
  return states_[step] = read(step);
}

CoarseStates::Place CoarseStates::place_of(double time) const {
  const double place = std::max(0.0, time) / step_;
  // A time that is a step's but for rounding needs no state after it.
  const double nearest = std::round(place);
  if (std::abs(place - nearest) < 1e-6) return {static_cast<std::int64_t>(nearest), 0};
  return {static_cast<std::int64_t>(std::floor(place)), place - std::floor(place)};
}

InputState CoarseStates::fine_state(double time) {
  const Place place = place_of(time);
  const Known first = state(place.step);
  if (place.share == 0) return upsampled(first.meshes->level, first.coarse);
  const Known& second = state(place.step + 1);
  if (first.meshes == second.meshes)
    return upsampled(first.meshes->level, between(first.coarse, second.coarse, place.share));
  return between(upsampled(first.meshes->level, first.coarse),
                 upsampled(second.meshes->level, second.coarse), place.share);
}

CoarseScene CoarseStates::level_at(double time) {
  return state(place_of(time).step).meshes->level;
}

double CoarseStates::peak_kinetic(double time) {
  const std::int64_t last = place_of(time).step;
  if (remeshes(begun_.scene)) return state(last).peak_kinetic;
  double peak = 0;
  const int each = frame_steps(begun_.scene.time);
  for (std::int64_t step = 0; step <= last; step += each) {
    const Known& known = state(step);
    peak = std::max(peak, kinetic_energy(known.meshes->model, known.coarse));
  }
  return peak;
}

std::shared_ptr<Tracking> tracking_of(const Scene& fine, const CoarseScene& level,
                                      std::shared_ptr<CoarseStates> states) {
  auto tracking = std::make_shared<Tracking>(make_tracking(fine, level));
  tracking->target = [states = std::move(states)](double time) {
    return states->fine_state(time).positions;
  };
  return tracking;
}

}  // namespace weft
