#include "host/state/checkpoint.hpp"

#include <cmath>
#include <cstring>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {
namespace {

/// One triangle; a checkpoint takes from a model what names its topology.
Model triangle_model() {
  Model model;
  model.to_input = {2, 0, 1};
  model.triangles = {{{0, 1, 2}}};
  model.material_points = {{0, 0}, {1, 0}, {0, 1}};
  return model;
}

template <class T>
StateSnapshot<T> triangle_state() {
  StateSnapshot<T> state;
  state.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  state.velocities = state.previous_positions = state.previous_velocities = state.positions;
  state.touched = {0, 1, 0};
  return state;
}

template <class T>
void require_finite(const std::vector<Vec3<T>>& values) {
  require(values.size() == 3, "a state of another size");
  for (const Vec3<T>& x : values)
    for (int k = 0; k < 3; ++k) require(std::isfinite(x[k]), "a state that is not finite");
}

template <class T>
void read(const std::filesystem::path& path) {
  const Model model = triangle_model();
  const Scene scene;
  StateSnapshot<T> state = triangle_state<T>();
  accepted([&] { return read_sewing(path, 2, 1); });
  const auto good = accepted([&] {
    read_checkpoint(path, scene, model, state);
    return true;
  });
  if (!good) return;
  require(std::isfinite(state.time) && state.time >= 0 && state.step_number >= 0 &&
              std::isfinite(state.previous_step) && state.previous_step >= 0,
          "a time that cannot be");
  require(state.backoff.left >= 0 && state.backoff.left <= state.backoff.run &&
              state.backoff.run <= Backoff::run_max && state.backoff.truncated >= 0 &&
              state.backoff.stretched >= 0 && state.backoff.stretched <= Backoff::run_max,
          "steps in halves that cannot be");
  for (const auto* values :
       {&state.positions, &state.velocities, &state.previous_positions, &state.previous_velocities})
    require_finite(*values);
  write_checkpoint(folder() / "again.weft", scene, model, state, {});
  StateSnapshot<T> again = triangle_state<T>();
  read_checkpoint(folder() / "again.weft", scene, model, again);
  require(again.positions == state.positions && again.velocities == state.velocities &&
              again.previous_positions == state.previous_positions &&
              again.previous_velocities == state.previous_velocities &&
              again.touched == state.touched && again.time == state.time &&
              again.step_number == state.step_number && again.backoff == state.backoff,
          "the state is another once it is written and read");
}

/// Gives each chunk its checksum.
std::string with_checksums(std::string bytes) {
  constexpr std::size_t head = 32;
  for (std::size_t at = 12; at + head <= bytes.size();) {
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data() + at + 16, sizeof size);
    if (size > bytes.size() - at - head) break;
    const std::uint64_t sum = checksum_of(std::string_view(bytes).substr(at + head, size));
    std::memcpy(bytes.data() + at + 24, &sum, sizeof sum);
    at += head + size;
  }
  return bytes;
}

}  // namespace

void checkpoint(std::string_view input) {
  const auto path = put("input.weft", input);
  read<float>(path);
  put("input.weft", with_checksums(std::string(input)));
  read<float>(path);
  read<double>(path);
}

}  // namespace weft::fuzz
