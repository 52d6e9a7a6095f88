#include "host/time_parallel/frozen_meshes.hpp"

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "host/scene/store.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "weft/devices.hpp"

namespace weft {
namespace {

/// Remeshes of one start. Later ones change a few edges where detail is finer than the coarse mesh.
constexpr int rounds_max = 4;
/// One that changes fewer edges than this share of the vertices is the last.
constexpr double changes_few = 0.01;

/// Sizes of cloths whose own meshes are coarser than those of the coarse run: as fine as these, so
/// that all that the coarse run knows is there to be seen by the criteria.
/// @return whether there are any
bool as_fine_as_coarse(const CoarseScene& level, Scene& fine) {
  bool any = false;
  for (std::size_t c = 0; c < fine.cloths.size(); ++c) {
    Cloth& cloth = fine.cloths[c];
    if (cloth.mesh.triangles.size() >= level.scene.cloths[c].mesh.triangles.size()) continue;
    Remeshing& sizes = *cloth.remeshing;
    sizes.size_min = sizes.size_max = fine.time_parallel.coarsening * sizes.size_min;
    constexpr double none = std::numeric_limits<double>::infinity();
    sizes.refine_angle = sizes.refine_compression = sizes.refine_velocity = none;
    any = true;
  }
  return any;
}

bool changes_little(const SceneRemesh& remesh) {
  const auto changes =
      static_cast<double>(remesh.counts.splits + remesh.counts.flips + remesh.counts.collapses);
  return changes <= changes_few * static_cast<double>(remesh.state.positions.size());
}

/// One remesh of the scene in the state that the coarse run gives on its meshes.
template <class T>
SceneRemesh remesh_once(FrozenMeshes& meshes, CoarseStates& states, const StartTime& start) {
  DeviceSet devices = host_devices(1);
  Store<T> store(meshes.fine, devices);
  const PlacedState placed = placed_state(meshes.fine, store.model(), states, start);
  StateSnapshot<T> state = snapshot_of(store, placed, start);
  // As at the start of a run: there is no energy to keep yet.
  state.step_number = 0;
  store.restore(state);
  return remesh_run(meshes.fine, {}, meshes.run, store, 0);
}

}  // namespace

template <class T>
bool freeze_meshes(const Scene& fine, const CoarseScene& level, const StartTime& start,
                   const std::filesystem::path& states,
                   const std::function<bool(double work)>& go_on, FrozenMeshes& meshes) {
  meshes.fine = fine;
  meshes.run = begin_adaptive(meshes.fine);
  std::vector<std::optional<Remeshing>> own;
  for (const Cloth& cloth : meshes.fine.cloths) own.push_back(cloth.remeshing);
  bool few = false;
  for (int round = as_fine_as_coarse(level, meshes.fine) ? -1 : 0; round < rounds_max && !few;
       ++round) {
    CoarseStates known(level, states, meshes.fine);
    if (round <= 0) meshes.run.peak_kinetic = known.peak_kinetic(start.now);
    few = changes_little(remesh_once<T>(meshes, known, start)) && round >= 0;
    for (std::size_t c = 0; c < own.size(); ++c) meshes.fine.cloths[c].remeshing = own[c];
    if (!go_on(remesh_work(cloth_rows(meshes.fine)))) return false;
  }
  return true;
}

template bool freeze_meshes<float>(const Scene&, const CoarseScene&, const StartTime&,
                                   const std::filesystem::path&, const std::function<bool(double)>&,
                                   FrozenMeshes&);
template bool freeze_meshes<double>(const Scene&, const CoarseScene&, const StartTime&,
                                    const std::filesystem::path&,
                                    const std::function<bool(double)>&, FrozenMeshes&);

}  // namespace weft
