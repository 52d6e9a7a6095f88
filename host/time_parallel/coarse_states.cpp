#include "host/time_parallel/coarse_states.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "host/scene/checkpoint.hpp"
#include "host/scene/frame_steps.hpp"

namespace weft {
namespace {

constexpr std::size_t states_kept = 4;

std::vector<Vec3<double>> between(const std::vector<Vec3<double>>& a,
                                  const std::vector<Vec3<double>>& b, double share) {
  std::vector<Vec3<double>> result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = (1 - share) * a[i] + share * b[i];
  return result;
}

}  // namespace

CoarseStates::CoarseStates(const CoarseScene& level, std::filesystem::path directory)
    : level_(level),
      directory_(std::move(directory)),
      step_(frame_step_length(level.scene.time)),
      model_(make_model(level.scene)) {}

std::filesystem::path CoarseStates::file(const std::filesystem::path& directory,
                                         std::int64_t step) {
  char name[40];
  std::snprintf(name, sizeof name, "state_%06lld.weft", static_cast<long long>(step));
  return directory / name;
}

template <class T>
InputState CoarseStates::read(std::int64_t step) const {
  StateSnapshot<T> state;
  const auto all = static_cast<std::size_t>(model_.vertex_count);
  const auto cloth = static_cast<std::size_t>(model_.cloth_vertex_count);
  state.positions.resize(all);
  state.previous_positions.resize(all);
  state.velocities.resize(cloth);
  state.previous_velocities.resize(cloth);
  state.touched.resize(all);
  read_checkpoint(file(directory_, step), level_.scene, model_, state);
  InputState inputs;
  for (const Index v : model_.to_internal) {
    inputs.positions.push_back(vec_cast<double>(state.positions[static_cast<std::size_t>(v)]));
    inputs.velocities.push_back(vec_cast<double>(state.velocities[static_cast<std::size_t>(v)]));
  }
  return inputs;
}

const InputState& CoarseStates::state(std::int64_t step) {
  const auto found = states_.find(step);
  if (found != states_.end()) return found->second;
  if (states_.size() >= states_kept) states_.erase(states_.begin());
  return states_[step] = level_.scene.precision == Precision::single_precision ? read<float>(step)
                                                                               : read<double>(step);
}

InputState CoarseStates::at(double time) {
  const double place = std::max(0.0, time) / step_;
  // A time that is a step's but for rounding needs no state after it.
  const double nearest = std::round(place);
  if (std::abs(place - nearest) < 1e-6) return state(static_cast<std::int64_t>(nearest));
  const auto before = static_cast<std::int64_t>(std::floor(place));
  const double share = place - std::floor(place);
  const InputState first = state(before);
  const InputState& second = state(before + 1);
  return {between(first.positions, second.positions, share),
          between(first.velocities, second.velocities, share)};
}

std::vector<Vec3<double>> CoarseStates::fine_positions(double time) {
  return upsampled(level_, at(time).positions);
}

std::shared_ptr<Tracking> tracking_of(const Scene& fine, const CoarseScene& level,
                                      std::shared_ptr<CoarseStates> states) {
  auto tracking = std::make_shared<Tracking>(make_tracking(fine, level));
  tracking->target = [states = std::move(states)](double time) {
    return states->fine_positions(time);
  };
  return tracking;
}

}  // namespace weft
