#include "host/simulation/handle_states.hpp"

#include <set>

#include "host/model/springs.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/spring.hpp"

namespace weft {
namespace {

/// [kg] Vertices that are sewn to another cloth count whole.
double mass_of(const Scene& scene, const Model& model, Index cloth) {
  std::set<Index> own;
  const auto count = static_cast<Index>(scene.cloths[at(cloth)].mesh.positions.size());
  for (Index v = 0; v < count; ++v)
    own.insert(model.to_internal[at(model.input_offset[at(cloth)] + v)]);
  double mass = 0;
  for (const Index v : own) mass += model.mass[at(v)];
  return mass;
}

}  // namespace

template <class T>
std::vector<HandleState> handle_states(const Store<T>& store) {
  const Scene& scene = store.scene();
  const Model& model = store.model();
  if (scene.handles.empty()) return {};
  const StateSnapshot<T> state = store.snapshot();
  const double gravity = length(scene.gravity);
  std::vector<HandleState> states;
  for (const Handle& handle : scene.handles) {
    HandleState one{scene.cloths[at(handle.cloth)].name, {}, 0};
    for (const Spring<double>& s : springs_of(scene, model, handle, state.time)) {
      if (s.v[1] >= 0) continue;
      const Vec3<double> d = vec_cast<double>(state.positions[at(s.v[0])]) - s.anchor;
      one.force += spring_force(spring_span(d, s.along), s.rest, s.stiffness);
    }
    if (gravity > 0)
      one.weight_share = -dot(one.force, scene.gravity) /
                         (gravity * gravity * mass_of(scene, model, handle.cloth));
    states.push_back(std::move(one));
  }
  return states;
}

template std::vector<HandleState> handle_states(const Store<float>&);
template std::vector<HandleState> handle_states(const Store<double>&);

}  // namespace weft
