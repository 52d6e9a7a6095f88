#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/time_parallel/slices.hpp"

namespace weft::app {

// How a slice that another process simulates is told how far to go. It asks and reports, a line
// each, and some lines are answered:
//   r WORK          recovering    -> 1 go on, 0 stop
//   m DONE          may it step?  -> 1 yes, 0 it ends here, 2 stop
//   b DONE WORK...  work counted so far, of a process that has begun
//   w DONE WORK...  work counted since the last such line
//   e KIND TEXT     what ended it: SceneError, DeviceError, SimulationError
//   f NUMBER TEXT   a step failed: Failure and its detail

/// Who simulates a slice, as seen by who decides.
class SliceWorkerLink {
 public:
  virtual ~SliceWorkerLink() = default;
  /// @return none: it is done, or gone
  virtual std::optional<std::string> line() = 0;
  virtual void answer(char c) = 0;
};

/// What is known of a slice, whichever process simulates it.
struct HeardOfSlice {
  std::vector<double> work;
  std::int64_t done = 0;
  bool over = false;  ///< it was told where it ends, or to stop
  Failure failure = Failure::none;
  std::string failure_detail;
  bool stepped = false;  ///< since the process began
};

/// Takes one line of a worker, and answers it.
/// @throws SceneError, DeviceError, SimulationError that the line tells of
void hear_slice(const std::string& line, SliceWorkerLink& worker, SliceGate& gate,
                HeardOfSlice& heard);

/// Who decides, as seen by who simulates a slice.
class SliceAskerLink {
 public:
  virtual ~SliceAskerLink() = default;
  virtual void say(const std::string& line) = 0;
  /// @return '2' if there is nobody left
  virtual char answer() = 0;
};

/// Simulates a slice as far as it is told; how it ended is said, not thrown.
void simulate_slice_for(SliceAskerLink& asker, const TimeParallelScene& scene,
                        const SliceTask& task, const std::string& device);

/// Says what an error was that ended a slice.
/// @param work does it; what it throws is said
void say_errors(SliceAskerLink& asker, const std::function<void()>& work);

}  // namespace weft::app
