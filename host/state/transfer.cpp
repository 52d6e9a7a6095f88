#include "host/state/transfer.hpp"

#include <algorithm>
#include <utility>

#include "host/state/contact_transfer.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Values of all vertices from one order to another, those of cloth by way of input numbers.
template <class T>
std::vector<Vec3<T>> reordered(const Model& from, const std::vector<Vec3<T>>& values,
                               const std::vector<std::vector<std::array<Index, 2>>>& parents,
                               const Model& to) {
  std::vector<Vec3<T>> by_input;
  by_input.reserve(from.to_internal.size());
  for (const Index v : from.to_internal) by_input.push_back(values[at(v)]);
  for (const auto& level : parents) {
    std::vector<Vec3<T>> finer;
    finer.reserve(level.size());
    for (const auto& [a, b] : level)
      finer.push_back(a == b ? by_input[at(a)] : T(0.5) * (by_input[at(a)] + by_input[at(b)]));
    by_input = std::move(finer);
  }
  std::vector<Vec3<T>> result;
  result.reserve(at(to.vertex_count));
  for (const Index input : to.to_input) result.push_back(by_input[at(input)]);
  result.insert(result.end(), values.begin() + from.cloth_vertex_count, values.end());
  return result;
}

/// Numbers of the vertices of `from` in `to`, which has the same inputs.
std::vector<Index> renumbering(const Model& from, const Model& to) {
  std::vector<Index> vertex;
  for (const Index input : from.to_input) vertex.push_back(to.to_internal[at(input)]);
  for (Index v = from.cloth_vertex_count; v < from.vertex_count; ++v)
    vertex.push_back(v - from.cloth_vertex_count + to.cloth_vertex_count);
  return vertex;
}

/// Whether seams or glue tie any two vertices to each other.
bool ties_any(const Model& model) {
  for (std::size_t v = 0; v < model.tied.size(); ++v)
    if (model.tied[v] != static_cast<Index>(v)) return true;
  return false;
}

}  // namespace

template <class T>
StateSnapshot<T> merged_state(const Model& model, const std::vector<Index>& group,
                              const std::vector<unsigned char>& fixed, StateSnapshot<T> state) {
  struct Sum {
    double mass = 0;
    Vec3<double> position{};
    Vec3<double> velocity{};
    Vec3<double> displacement{};  ///< in the last step
    Vec3<double> previous_velocity{};
    unsigned char touched = 0;
    int count = 0;
    Index prescribed = -1;
  };
  std::vector<Sum> sums(group.size());
  for (std::size_t v = 0; v < group.size(); ++v) {
    Sum& sum = sums[at(group[v])];
    sum.mass += model.mass[v];
    sum.position += model.mass[v] * vec_cast<double>(state.positions[v]);
    sum.velocity += model.mass[v] * vec_cast<double>(state.velocities[v]);
    sum.displacement +=
        model.mass[v] * vec_cast<double>(state.positions[v] - state.previous_positions[v]);
    sum.previous_velocity += model.mass[v] * vec_cast<double>(state.previous_velocities[v]);
    sum.touched = std::max(sum.touched, state.touched[v]);
    ++sum.count;
    if (fixed[v] != 0 && sum.prescribed < 0) sum.prescribed = static_cast<Index>(v);
  }
  const StateSnapshot<T> before = state;
  for (std::size_t v = 0; v < group.size(); ++v) {
    const Sum& sum = sums[at(group[v])];
    if (sum.count == 1) continue;
    state.touched[v] = sum.touched;
    if (sum.prescribed >= 0) {
      state.positions[v] = before.positions[at(sum.prescribed)];
      state.velocities[v] = before.velocities[at(sum.prescribed)];
      state.previous_positions[v] = before.previous_positions[at(sum.prescribed)];
      state.previous_velocities[v] = before.previous_velocities[at(sum.prescribed)];
    } else {
      state.positions[v] = vec_cast<T>((1 / sum.mass) * sum.position);
      state.velocities[v] = vec_cast<T>((1 / sum.mass) * sum.velocity);
      // The way to the common place is no motion.
      state.previous_positions[v] =
          state.positions[v] - vec_cast<T>((1 / sum.mass) * sum.displacement);
      state.previous_velocities[v] = vec_cast<T>((1 / sum.mass) * sum.previous_velocity);
    }
  }
  return state;
}

template <class T>
StateSnapshot<T> transferred(const Model& from, const StateSnapshot<T>& state,
                             const std::vector<std::vector<std::array<Index, 2>>>& parents,
                             const Model& to) {
  StateSnapshot<T> result;
  result.time = state.time;
  result.step_number = state.step_number;
  result.backoff = state.backoff;
  result.next_step = state.next_step;
  result.positions = reordered(from, state.positions, parents, to);
  result.velocities = reordered(from, state.velocities, parents, to);
  if (!parents.empty()) {
    result.previous_positions = result.positions;
    result.previous_velocities = result.velocities;
    result.touched.assign(result.positions.size(), 0);
    return result;
  }
  result.previous_step = state.previous_step;
  result.previous_positions = reordered(from, state.previous_positions, parents, to);
  result.previous_velocities = reordered(from, state.previous_velocities, parents, to);
  const std::vector<Index> vertex = renumbering(from, to);
  result.touched.resize(result.positions.size());
  for (std::size_t v = 0; v < vertex.size(); ++v) result.touched[at(vertex[v])] = state.touched[v];
  // Beside pairs that still pull, contacts that go on from their forces hold the cloth apart.
  transfer_contacts(from, state, vertex, to, !ties_any(to), result);
  return result;
}

template StateSnapshot<float> merged_state(const Model&, const std::vector<Index>&,
                                           const std::vector<unsigned char>&, StateSnapshot<float>);
template StateSnapshot<double> merged_state(const Model&, const std::vector<Index>&,
                                            const std::vector<unsigned char>&,
                                            StateSnapshot<double>);
template StateSnapshot<float> transferred(const Model&, const StateSnapshot<float>&,
                                          const std::vector<std::vector<std::array<Index, 2>>>&,
                                          const Model&);
template StateSnapshot<double> transferred(const Model&, const StateSnapshot<double>&,
                                           const std::vector<std::vector<std::array<Index, 2>>>&,
                                           const Model&);

}  // namespace weft
