#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/app/process/stop_signal.hpp"
#include "host/app/run/energy_balance.hpp"
#include "host/app/run/frame_writer.hpp"
#include "host/app/run/heartbeat.hpp"
#include "host/app/run/progress.hpp"
#include "host/app/run/run_device.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_end.hpp"
#include "host/app/run/run_lock.hpp"
#include "host/app/run/run_output.hpp"
#include "host/app/run/run_report.hpp"
#include "host/app/run/run_request.hpp"
#include "host/app/view/live_server.hpp"
#include "host/base/job_queue.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/simulation.hpp"

namespace weft::app {

/// Name of the directory of a run.
std::string output_of(const RunRequest& request, const Scene& scene);

/// A run of a scene step by step: its frames, checkpoints, report and messages.
class SceneRun {
 public:
  /// @throws SceneError, DeviceError as Simulation; TangledStart
  SceneRun(const RunRequest& request, io::SceneFile file)
      : SceneRun(request, std::move(file),
                 device_of(request, file, output_of(request, file.scene))) {}

  /// Simulates it to its end.
  /// @return the exit code
  int execute();

 private:
  SceneRun(const RunRequest& request, io::SceneFile&& file, RunDevice device)
      : request_(request),
        resolved_(std::move(file.resolved)),
        device_(std::move(device)),
        directory_(output_of(request, file.scene)),
        lock_(lock_existing(directory_, request)),
        simulation_(std::move(file.scene), stoppable_devices(device_.text)),
        start_energy_(simulation_.energy()),
        totals_(start_energy_),
        balance_(simulation_.scene(), start_energy_) {}

  void serve();
  void begin();
  void begin_from_checkpoint();
  void make_directory();
  bool frame_complete() const { return simulation_.at_frame_end(); }
  StepReport step(Progress& progress, Heartbeat& heartbeat);
  void warn_of_compliance(const StepReport& report, Progress& progress);
  void warn_of_gain(Progress& progress);
  void warn_of_limits(const StepReport& report, Progress& progress);
  /// What to change for shorter steps.
  const char* shorter_steps() const {
    return simulation_.scene().time.automatic ? "smaller time.tolerance" : "shorter time.step";
  }
  void write_frame(int number);
  void save_checkpoint();
  int finish_whole();
  int finish_gaining();
  int finish(const std::optional<std::string>& failure, ExitCode code,
             const std::optional<Vec3<double>>& place = {});
  void print_garments() const;
  void print_rest() const;
  void print_attachments() const;
  void print_summary(bool preview) const;
  double lap();

  const RunRequest& request_;
  nlohmann::json resolved_;
  RunDevice device_;
  RunDirectory directory_;
  std::unique_ptr<RunLock> lock_;  ///< null: the directory is yet to be made
  std::chrono::steady_clock::time_point lap_start_ = std::chrono::steady_clock::now();
  Simulation simulation_;
  Energy start_energy_;
  RunTotals totals_;
  EnergyBalance balance_;
  bool gain_said_ = false;
  bool gained_ = false;  ///< the run ends because of energy from nothing
  std::unique_ptr<StepLog> log_;
  std::unique_ptr<LiveServer> live_;  ///< null: nobody watches
  /// Used by writing_ alone, until that is done.
  FrameWriter frames_{directory_, simulation_.scene()};
  std::filesystem::path checkpoint_;  ///< the last one written or resumed from
  std::int64_t checkpoint_step_ = -1;
  std::shared_ptr<const std::string> start_;  ///< state to begin with, until there is a checkpoint
  bool compliance_said_ = false;
  bool limits_said_ = false;
  /// Frames and checkpoints on their way to the disk, while the next steps are computed.
  JobQueue writing_{2};
};

}  // namespace weft::app
