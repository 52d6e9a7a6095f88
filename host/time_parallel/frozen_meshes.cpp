#include "host/time_parallel/frozen_meshes.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "host/state/store.hpp"
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
/// that all that the coarse run knows is there to be seen by the criteria. The others stay as they
/// are meanwhile.
/// @return whether there are any
bool as_fine_as_coarse(const CoarseScene& level, Scene& fine) {
  const auto coarser = [&](std::size_t c) {
    return fine.cloths[c].mesh.triangles.size() < level.scene.cloths[c].mesh.triangles.size();
  };
  bool any = false;
  for (std::size_t c = 0; c < fine.cloths.size(); ++c) any = any || coarser(c);
  if (!any) return false;
  for (std::size_t c = 0; c < fine.cloths.size(); ++c) {
    Cloth& cloth = fine.cloths[c];
    if (!coarser(c)) {
      cloth.remeshing = even_sizes(cloth.mesh, 1);
      continue;
    }
    Remeshing& sizes = *cloth.remeshing;
    sizes.size_min = sizes.size_max = fine.time_parallel.coarsening * sizes.size_min;
    constexpr double none = std::numeric_limits<double>::infinity();
    sizes.refine_angle = sizes.refine_compression = sizes.refine_velocity = none;
  }
  return true;
}

bool changes_little(const RemeshCounts& counts, std::int64_t rows) {
  const auto changes = static_cast<double>(counts.splits + counts.flips + counts.collapses);
  return changes <= changes_few * static_cast<double>(rows);
}

/// The state that the coarse run gives on the meshes as they are.
PlacedState place(const FrozenMeshes& meshes, CoarseStates& states, const StartTime& start) {
  return placed_state(meshes.fine, make_model(meshes.fine), states, start);
}

/// One remesh of the scene in a state, which it takes to the new meshes.
template <class T>
RemeshCounts remesh_once(FrozenMeshes& meshes, PlacedState& placed, const StartTime& start) {
  DeviceSet devices = host_devices(1);
  Store<T> store(meshes.fine, devices);
  StateSnapshot<T> state = snapshot_of(store, placed, start);
  // As at the start of a run: there is no energy to keep yet.
  state.step_number = 0;
  store.restore(state);
  SceneRemesh remesh = remesh_run(meshes.fine, {}, meshes.run, store, 0);
  if (remesh.changed()) {
    meshes.fine = std::move(remesh.scene);
    meshes.run.kept = std::move(remesh.kept);
    placed.cloth = std::move(remesh.state);
  }
  return remesh.counts;
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
  PlacedState placed;
  for (int round = as_fine_as_coarse(level, meshes.fine) ? -1 : 0; round < rounds_max && !few;
       ++round) {
    // Once more on the meshes that are as fine as the coarse ones, never on finer ones: there the
    // facets of the coarse meshes would be seen for folds.
    if (round <= 0) {
      if (!go_on(0)) return false;
      CoarseStates known(level, states, meshes.fine);
      meshes.run.peak_kinetic = known.peak_kinetic(start.now);
      placed = place(meshes, known, start);
    }
    const RemeshCounts counts = remesh_once<T>(meshes, placed, start);
    for (std::size_t c = 0; c < own.size(); ++c) meshes.fine.cloths[c].remeshing = own[c];
    const std::int64_t rows = cloth_rows(meshes.fine);
    few = round >= 0 && changes_little(counts, rows);
    if (!go_on(remesh_work(rows))) return false;
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
