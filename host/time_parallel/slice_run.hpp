#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/atomic_file.hpp"
#include "host/time_parallel/coarse_scene.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "weft/devices.hpp"
#include "weft/frame.hpp"
#include "weft/report.hpp"
#include "weft/simulation.hpp"

namespace weft {

/// Names of the files of a slice. The files hold everything that the slice needs, so an interrupted
/// slice continues from them with the same bits.
class SliceFiles {
 public:
  /// @param run directory of the whole run
  SliceFiles(const std::filesystem::path& run, int slice);

  const std::filesystem::path& directory() const { return directory_; }
  std::filesystem::path start() const { return directory_ / "start.weft"; }
  std::filesystem::path start_report() const { return directory_ / "start.txt"; }
  std::filesystem::path checkpoint() const { return directory_ / "checkpoint.weft"; }
  std::filesystem::path work() const { return directory_ / "work.bin"; }
  /// The state after the last step. The file exists once the slice is done.
  std::filesystem::path end() const { return directory_ / "end.weft"; }

  static std::filesystem::path coarse(const std::filesystem::path& run) { return run / "coarse"; }
  static std::filesystem::path slices(const std::filesystem::path& run) { return run / "slices"; }

 private:
  std::filesystem::path directory_;
};

/// Tells a slice how far it may go, and receives its progress.
class SliceGate {
 public:
  virtual ~SliceGate() = default;
  /// Called before each step. May block until the answer is known.
  /// @param done number of steps done, counted from the start of the run
  /// @return     false: the slice ends here, or everything stops
  virtual bool may_step(std::int64_t done) = 0;
  /// Called after each step.
  /// @param work [steps of the slice + 1] total counted work after recovery and after each step so
  ///             far
  virtual void stepped(std::int64_t done, const std::vector<double>& work) = 0;
  /// Called while the start of the slice is made.
  /// @param work counted so far
  /// @return     false: everything stops
  virtual bool recovering(double work) = 0;
  /// Whether everything must stop at once.
  virtual bool stopping() = 0;
};

/// Receives the output of slices. Each slice calls it from one thread at a time.
class SliceSink {
 public:
  virtual ~SliceSink() = default;
  /// Called before the first step of a slice, or before its next step if it is resumed.
  /// @param done number of steps done, counted from the start of the run; earlier output of later
  ///             steps is void
  virtual void begin(int slice, std::int64_t done, const Energy& energy) = 0;
  virtual void step(int slice, const StepReport& report, const std::optional<Energy>& energy,
                    double wall) = 0;
  virtual void frame(int slice, const Scene& scene, const Frame& frame) = 0;
  /// Called before a checkpoint is written. All output so far must be stored first, so that the
  /// checkpoint is never ahead of the output.
  virtual void sync(int slice) = 0;
};

/// A slice to simulate.
struct SliceTask {
  int number = 0;
  std::int64_t first_step = 0;  ///< number of steps before it
  std::filesystem::path run;    ///< directory of the whole run
};

/// Outcome of a slice.
struct SliceOutcome {
  bool done = false;      ///< it reached its end
  SliceStart start;       ///< not used by the first slice
  std::int64_t end = 0;   ///< steps done, counted from the start of the run
  double work = 0;        ///< counted, including recovery
  double wall = 0;        ///< [s] of its steps in this process
  double start_wall = 0;  ///< [s] of making its start in this process
  Failure failure = Failure::none;
  std::string failure_detail;
};

/// Simulates a slice, or the rest of it, until the gate ends it.
/// @param fine scene with the method of the slices
/// @throws SceneError, DeviceError, SimulationError as Simulation and write_slice_start()
SliceOutcome run_slice(const Scene& fine, const CoarseScene& level, const SliceTask& task,
                       DeviceSet devices, SliceGate& gate, SliceSink& sink);

/// Outcome of a slice that an earlier run has finished, from its files.
/// @return none if the slice is not done
/// @throws SceneError if one of its files is missing or damaged
std::optional<SliceOutcome> finished_slice(const SliceTask& task);

/// Reads the counted work that was written with a checkpoint; empty if there is none.
std::vector<double> read_work(const std::filesystem::path& file);
void write_work(const std::filesystem::path& file, const std::vector<double>& work,
                Durability durability = Durability::fsync);

}  // namespace weft
