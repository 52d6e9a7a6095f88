#include "host/time_parallel/seam_states.hpp"

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>
#include <utility>

#include "host/scene/parallel.hpp"
#include "host/time_parallel/slice_run.hpp"
#include "weft/devices.hpp"

namespace weft {

SeamStates::SeamStates(const Scene& fine, std::filesystem::path run)
    : run_(std::move(run)), simulation_(fine, host_devices(1)) {}

std::array<Frame, 2> SeamStates::at(int slice) {
  std::array<Frame, 2> frames;
  simulation_.resume(SliceFiles(run_, slice - 1).end());
  frames[0] = simulation_.frame();
  simulation_.resume(SliceFiles(run_, slice).start());
  frames[1] = simulation_.frame();
  return frames;
}

void for_each_seam(const Scene& fine, const std::filesystem::path& run, int slices, int threads,
                   const std::function<void(int slice, const std::array<Frame, 2>& states)>& look) {
  std::atomic<int> next{1};
  // Each holds a whole simulation: no more of them than cores, however many workers there were.
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int at_once = std::clamp(std::min(threads, cores), 1, std::max(slices - 1, 1));
  on_threads(static_cast<unsigned>(at_once), [&](unsigned) {
    std::optional<SeamStates> states;
    for (int slice = next++; slice < slices; slice = next++) {
      if (!states) states.emplace(fine, run);
      look(slice, states->at(slice));
    }
  });
}

}  // namespace weft
