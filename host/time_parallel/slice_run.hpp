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

/// Names of the files of a slice. All that is worth keeping is on the disk: a slice that was cut
/// off goes on from there, with the same bits.
class SliceFiles {
 public:
  /// @param run directory of the whole run
  SliceFiles(const std::filesystem::path& run, int slice);

  const std::filesystem::path& directory() const { return directory_; }
  std::filesystem::path start() const { return directory_ / "start.weft"; }
  std::filesystem::path start_report() const { return directory_ / "start.txt"; }
  std::filesystem::path checkpoint() const { return directory_ / "checkpoint.weft"; }
  std::filesystem::path work() const { return directory_ / "work.bin"; }
  /// What its steps took by the clock, where the partition asks for that. [s]
  std::filesystem::path clock() const { return directory_ / "clock.bin"; }
  /// The state after the last step; there once the slice is done.
  std::filesystem::path end() const { return directory_ / "end.weft"; }

  static std::filesystem::path coarse(const std::filesystem::path& run) { return run / "coarse"; }
  static std::filesystem::path slices(const std::filesystem::path& run) { return run / "slices"; }

 private:
  std::filesystem::path directory_;
};

/// Who tells a slice how far to go, and hears how far it is.
class SliceGate {
 public:
  virtual ~SliceGate() = default;
  /// Before a step, with the steps done so far, counted from the start of the run; may block until
  /// it is known.
  /// @return false: this is where the slice ends, or everything is to stop
  virtual bool may_step(std::int64_t done) = 0;
  /// @param work [steps of the slice + 1] counted after recovery and after each step so far; with
  ///             TimeParallelSettings::by_clock: [s]
  virtual void stepped(std::int64_t done, const std::vector<double>& work) = 0;
  /// While the start of the slice is made.
  /// @param work likewise, so far
  /// @return     false: everything is to stop
  virtual bool recovering(double work) = 0;
  /// Everything is to stop where it is.
  virtual bool stopping() = 0;
};

/// Takes what a slice gives; each slice calls from one thread at a time.
class SliceSink {
 public:
  virtual ~SliceSink() = default;
  /// Before the first step of a slice, or of the rest of it.
  /// @param done steps that are done, counted from the start of the run; what came after is void
  virtual void begin(int slice, std::int64_t done, const Energy& energy) = 0;
  virtual void step(int slice, const StepReport& report, const std::optional<Energy>& energy,
                    double wall) = 0;
  virtual void frame(int slice, const Scene& scene, const Frame& frame) = 0;
  /// A checkpoint is about to be written, which must not know more than what was taken.
  virtual void sync(int slice) = 0;
};

/// What one slice is to do.
struct SliceTask {
  int number = 0;
  std::int64_t first_step = 0;  ///< steps before it
  std::filesystem::path run;    ///< directory of the whole run
};

/// What became of it.
struct SliceOutcome {
  bool done = false;      ///< it has come to its end
  SliceStart start;       ///< of slices but the first
  std::int64_t end = 0;   ///< steps done, counted from the start of the run
  double work = 0;        ///< counted, with recovery
  double wall = 0;        ///< [s] of its steps in this process
  double start_wall = 0;  ///< [s] of making its start in this process
  Failure failure = Failure::none;
  std::string failure_detail;
};

/// Simulates a slice, or what is left of it, from its start to where the gate ends it.
/// @param fine with the method of the slices
/// @throws SceneError, DeviceError, SimulationError as Simulation and write_slice_start()
SliceOutcome run_slice(const Scene& fine, const CoarseScene& level, const SliceTask& task,
                       DeviceSet devices, SliceGate& gate, SliceSink& sink);

/// The same if the slice is done already.
/// @param by_clock whether the partition is decided by the clock: its costs have to be there then
/// @return none if it is not
/// @throws SceneError if a file of it is missing or damaged
std::optional<SliceOutcome> finished_slice(const SliceTask& task, bool by_clock);

/// Counted work that was written with a checkpoint; empty if there is none.
std::vector<double> read_work(const std::filesystem::path& file);
void write_work(const std::filesystem::path& file, const std::vector<double>& work,
                Durability durability = Durability::fsync);

}  // namespace weft
