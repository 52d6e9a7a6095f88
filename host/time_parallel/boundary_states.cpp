#include "host/time_parallel/boundary_states.hpp"

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "host/base/parallel.hpp"
#include "host/time_parallel/material_frame.hpp"
#include "host/time_parallel/slice_boundary.hpp"
#include "host/time_parallel/slice_run.hpp"
#include "weft/devices.hpp"

namespace weft {

BoundaryStates::BoundaryStates(const Scene& fine, std::filesystem::path run)
    : run_(std::move(run)), simulation_(fine, host_devices(1)) {}

BoundarySides BoundaryStates::at(int slice) {
  simulation_.resume(SliceFiles(run_, slice - 1).end(), SceneChanges::allow);
  const Frame before = simulation_.local_frame();
  const std::vector<Mesh> ended = copied_meshes(simulation_.scene());
  simulation_.resume(SliceFiles(run_, slice).start(), SceneChanges::allow);
  const Scene& scene = simulation_.scene();
  return {scene, frame_on(before, cloth_meshes(ended), cloth_meshes(scene)),
          simulation_.local_frame()};
}

bool BoundaryStates::free_before(int slice) {
  simulation_.resume(SliceFiles(run_, slice - 1).end(), SceneChanges::allow);
  return free_of_intersections(simulation_.scene(), simulation_.local_frame());
}

void for_each_seam(const Scene& fine, const std::filesystem::path& run, int slices, int threads,
                   const std::function<void(int slice, BoundaryStates& states)>& look) {
  std::atomic<int> next{1};
  // Each holds a whole simulation: no more of them than cores, however many workers there were.
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int at_once = std::clamp(std::min(threads, cores), 1, std::max(slices - 1, 1));
  on_threads(static_cast<unsigned>(at_once), [&](unsigned) {
    std::optional<BoundaryStates> states;
    for (int slice = next++; slice < slices; slice = next++) {
      if (!states) states.emplace(fine, run);
      look(slice, *states);
    }
  });
}

}  // namespace weft
