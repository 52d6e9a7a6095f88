#include "host/simulation/state_energy.hpp"

#include "host/model/springs.hpp"
#include "host/state/energy.hpp"
#include "host/state/rank_geometry.hpp"

namespace weft {

template <class T>
Energy energy_of(Store<T>& store) {
  const StateSnapshot<T> state = store.snapshot();
  const Scene& scene = store.scene();
  const Model& model = store.model();
  return measure_energy(scene, model, cast_all<double>(state.positions),
                        cast_all<double>(state.velocities), springs_at(scene, model, state.time),
                        *store.plate(fixed_vertices(scene, model, state.time)));
}

template Energy energy_of(Store<float>&);
template Energy energy_of(Store<double>&);

}  // namespace weft
