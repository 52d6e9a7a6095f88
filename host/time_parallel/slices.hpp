#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/time_parallel/coarse_scene.hpp"
#include "host/time_parallel/slice_boundary.hpp"
#include "host/time_parallel/slice_run.hpp"
#include "weft/devices.hpp"

namespace weft {

/// Simulates a slice in place of run_slice(), such as in another process.
using SliceWorker = std::function<SliceOutcome(const SliceTask& task, SliceGate& gate)>;

/// How the slices of a run are worked off.
struct SliceOptions {
  int workers = 1;            ///< slices, the coarse run included, that are under way at once
  std::filesystem::path run;  ///< directory: states of the coarse run, and of slices
  std::vector<std::int64_t> starts;  ///< given partition: first steps of the slices; empty: as the
                                     ///< scene says
  SliceWorker worker;                ///< empty: threads of this process
  /// Devices of a slice. Called by the thread that works it off.
  std::function<DeviceSet(int slice)> devices;
  std::function<bool()> stop;  ///< asked now and then: everything is to stop
  /// Told of every start that is decided, the first one included.
  std::function<void(const std::vector<std::int64_t>& starts)> decided;
};

/// Cost of the coarse run, by what was counted and by the clock.
struct CoarseOutcome {
  std::int64_t steps = 0;    ///< of its own
  std::int64_t reached = 0;  ///< steps of the fine run
  double work = 0;
  double wall = 0;                 ///< [s] of its steps in this process
  std::vector<double> work_until;  ///< [steps + 1] work after each of its steps
  std::vector<double> wall_until;  ///< [steps + 1] [s] as above; zero in what was there already
  /// Of its own steps, those that jammed at first: from each on, contact is eased once more, see
  /// coarse_relaxations().
  std::vector<std::int64_t> relaxed;
  Failure failure = Failure::none;
  std::string failure_detail;
};

/// What became of a run.
struct SlicesOutcome {
  bool done = false;  ///< all slices are
  std::int64_t steps = 0;
  std::vector<std::int64_t> starts;  ///< decided so far
  std::vector<SliceOutcome> slices;  ///< [starts]
  CoarseOutcome coarse;
  std::vector<BoundaryJump> seams;  ///< [slices - 1] once all are done
  double wall = 0;                  ///< [s] in this process
  double boundaries_wall = 0;       ///< [s] of it: looking at the seams in the end
};

/// A scene with the method "time_parallel", ready to be worked off.
class TimeParallelScene {
 public:
  /// Makes the two levels.
  /// @param slices wanted; the scene's own setting comes before it
  /// @throws SceneError if the scene is not valid, has fewer steps than slices, or cannot be made
  ///         coarser
  TimeParallelScene(Scene scene, int slices);

  const Scene& fine() const { return fine_; }  ///< with the method of the slices
  const CoarseScene& coarse() const { return coarse_; }
  std::int64_t steps() const { return steps_; }
  int slices() const { return slices_; }

  /// @throws SceneError unless they are first steps of slices of this scene
  /// @param whole whether there has to be one for each slice
  void check_starts(const std::vector<std::int64_t>& starts, bool whole = true) const;

 private:
  Scene fine_;
  std::int64_t steps_ = 0;
  int slices_ = 1;
  CoarseScene coarse_;
};

/// Works all slices off that are not done yet, side by side. With the same starts: the same bits,
/// whoever works them off, however many at once, and however often it is interrupted.
/// @throws what run_slice() throws, of the first slice that does
SlicesOutcome run_slices(const TimeParallelScene& scene, const SliceOptions& options,
                         SliceSink& sink);

}  // namespace weft
