#include "host/app/run.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/app/chart/accuracy_target.hpp"
#include "host/app/process/show.hpp"
#include "host/app/process/stop_signal.hpp"
#include "host/app/run/allow_path.hpp"
#include "host/app/run/energy_balance.hpp"
#include "host/app/run/experimental.hpp"
#include "host/app/run/frame_writer.hpp"
#include "host/app/run/heartbeat.hpp"
#include "host/app/run/output_folder.hpp"
#include "host/app/run/progress.hpp"
#include "host/app/run/run_device.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_end.hpp"
#include "host/app/run/run_lock.hpp"
#include "host/app/run/run_output.hpp"
#include "host/app/run/run_report.hpp"
#include "host/app/run/scene_name.hpp"
#include "host/app/run/seam_verdict.hpp"
#include "host/app/time_parallel/slice_ranks.hpp"
#include "host/app/time_parallel/time_run.hpp"
#include "host/app/view/live_server.hpp"
#include "host/base/atomic_file.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/scene/tangled_start.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

std::vector<std::string> overrides_of(const RunRequest& request) {
  std::vector<std::string> overrides = request.overrides;
  if (!request.method.empty()) overrides.push_back("method.type=" + request.method);
  if (!request.precision.empty()) overrides.push_back("precision=" + request.precision);
  if (!request.frames.empty()) overrides.push_back("time.frames=" + request.frames);
  return overrides;
}

std::string output_of(const RunRequest& request, const Scene& scene) {
  return output_folder(request.output, scene.name).string();
}

/// A checkpoint that a run goes on from, and the directory whose steps.jsonl it continues.
struct Origin {
  fs::path file;
  bool same_directory = false;
  bool renumbered = false;  ///< its steps and frames have other numbers than those of this run
};

/// Resumes from a checkpoint; with --resume-changed from that of another scene too, and says what
/// differs.
/// @return whether steps and frames are numbered otherwise
bool resume_from(Simulation& simulation, const fs::path& file, const RunRequest& request) {
  const auto changes =
      simulation.resume(file, request.resume_changed ? SceneChanges::allow : SceneChanges::refuse);
  for (const std::string& change : changes)
    show(stderr, "weft: warning: {}: resumed although {}\n", file.string(), change);
  return std::any_of(changes.begin(), changes.end(),
                     [](const std::string& change) { return change.starts_with("time."); });
}

/// Takes over the newest checkpoint that is whole.
/// @throws SceneError if there is none
Origin resume_latest(Simulation& simulation, const RunDirectory& directory,
                     const RunRequest& request) {
  const auto files = directory.checkpoints();
  if (files.empty())
    throw SceneError(directory.path().string(), "--resume", "latest",
                     "a directory with a checkpoint; it has none, so run without --resume");
  std::optional<SceneError> first;
  for (const auto& file : files) {
    try {
      const bool renumbered = resume_from(simulation, file, request);
      if (first)
        show(stderr, "weft: warning: {}; resuming from {}\n", first->what(), file.string());
      return {file, true, renumbered};
    } catch (const SceneError& error) {
      if (!first) first = error;
    }
  }
  throw *first;
}

class Run {
 public:
  Run(const RunRequest& request, io::SceneFile file)
      : Run(request, std::move(file), device_of(request, file, output_of(request, file.scene))) {}

  int execute();

 private:
  Run(const RunRequest& request, io::SceneFile&& file, RunDevice device)
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
  bool declares_compliance() const;
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
  void print_rest() const;
  void print_summary(bool preview) const;
  double lap();

  const RunRequest& request_;
  nlohmann::json resolved_;
  RunDevice device_;
  RunDirectory directory_;
  std::unique_ptr<RunLock> lock_;  ///< null: the directory is yet to be made
  Clock::time_point lap_start_ = Clock::now();
  Simulation simulation_;
  Energy start_energy_;
  RunTotals totals_;
  EnergyBalance balance_;
  bool gain_said_ = false;
  bool gained_ = false;  ///< the run ends because of energy from nothing
  std::unique_ptr<StepLog> log_;
  std::unique_ptr<LiveServer> live_;  ///< null: nobody watches
  FrameWriter frames_{directory_, simulation_.scene()};
  fs::path checkpoint_;  ///< the last one written or resumed from
  std::int64_t checkpoint_step_ = -1;
  bool compliance_said_ = false;
  bool limits_said_ = false;
};

/// [s] since the last call
double Run::lap() {
  const auto now = Clock::now();
  const std::chrono::duration<double> seconds = now - lap_start_;
  lap_start_ = now;
  return seconds.count();
}

/// Touches the disk only once the scene, and the checkpoint if any, are known to be good.
void Run::make_directory() {
  directory_.create();
  if (!lock_) lock_ = std::make_unique<RunLock>(directory_.path());
}

void Run::begin_from_checkpoint() {
  Origin origin;
  if (request_.resume == "latest") {
    origin = resume_latest(simulation_, directory_, request_);
  } else {
    origin.file = request_.resume;
    origin.renumbered = resume_from(simulation_, origin.file, request_);
    std::error_code error;
    origin.same_directory =
        fs::equivalent(fs::absolute(origin.file).parent_path(), directory_.path(), error);
  }
  if (origin.renumbered && origin.same_directory)
    throw SceneError("", "--resume-changed",
                     "another time step or frame rate in the same directory",
                     "another directory, with -o: frames and steps have other numbers now");
  const fs::path steps = fs::absolute(origin.file).parent_path() / "steps.jsonl";
  const std::string kept = origin.renumbered ? ""
                                             : read_steps(steps, simulation_.step_number(),
                                                          [this](const StepLine& line) {
                                                            totals_.add(line);
                                                            balance_.add(line.report, line.energy);
                                                          });
  if (origin.renumbered || request_.resume_changed) balance_.restart(simulation_.energy());
  if (totals_.steps < simulation_.step_number())
    fmt::print(
        stderr,
        "weft: warning: {} lacks {} of the {} steps before the checkpoint; the report leaves "
        "them out\n",
        steps.string(), simulation_.step_number() - totals_.steps, simulation_.step_number());
  if (!origin.same_directory && !request_.overwrite) directory_.refuse_run();
  make_directory();
  if (origin.same_directory) {
    directory_.clear_after(simulation_.frame_number(), origin.file);
    frames_.keep_until(simulation_.frame_number());
  } else {
    directory_.clear();
  }
  log_ = std::make_unique<StepLog>(directory_.steps(), kept);
  checkpoint_ = origin.file;
  if (origin.same_directory) checkpoint_step_ = simulation_.step_number();
  if (frame_complete()) write_frame(simulation_.frame_number());
}

void Run::begin() {
  if (!request_.resume.empty()) {
    begin_from_checkpoint();
  } else {
    make_directory();
    if (!request_.overwrite) directory_.refuse_run();
    directory_.clear();
    log_ = std::make_unique<StepLog>(directory_.steps(), "");
    write_frame(0);
  }
  // Whoever reads this scene again, or goes on from here, is to take the same devices.
  resolved_["device"] = device_.text;
  write_file_atomically(directory_.scene(), resolved_.dump(2) + "\n");
}

void Run::write_frame(int number) {
  const Scene& scene = simulation_.scene();
  const FrameMeshes meshes = frame_meshes(scene, simulation_.local_frame());
  frames_.write(meshes, number);
  if (live_) live_->add_frame(number, simulation_.time(), meshes);
}

/// Lets a browser of this machine watch.
void Run::serve() {
  if (request_.live_port < 0) return;
  live_ = std::make_unique<LiveServer>(request_.live_port, simulation_.scene(), device_.text);
  show(stdout, "watch the run at {}\n", live_->address());
  std::fflush(stdout);
}

/// The steps and frames first: a checkpoint must never know more than they.
void Run::save_checkpoint() {
  log_->sync();
  frames_.sync();
  if (checkpoint_step_ == simulation_.step_number()) return;
  checkpoint_ = directory_.save_checkpoint(simulation_);
  checkpoint_step_ = simulation_.step_number();
}

StepReport Run::step(Progress& progress, Heartbeat& heartbeat) {
  StepLine line;
  {
    const Heartbeat::Watch watch(heartbeat);
    line.report = simulation_.step();
  }
  if (line.report.failure == Failure::none && frame_complete()) line.energy = simulation_.energy();
  line.wall = lap();
  if (line.report.failure == Failure::stopped) return line.report;  // as if it had not begun
  totals_.add(line);
  balance_.add(line.report, line.energy);
  log_->add(line);
  if (live_) live_->add_step(line);
  progress.step(line.report, simulation_.frame_number(), frame_complete(),
                simulation_.step_number(), line.wall);
  warn_of_compliance(line.report, progress);
  warn_of_gain(progress);
  warn_of_limits(line.report, progress);
  return line.report;
}

/// Says once that what the scene declares compliant has begun to give way.
void Run::warn_of_compliance(const StepReport& report, Progress& progress) {
  if (compliance_said_ || report.compliance_distance <= 0 || !declares_compliance()) return;
  compliance_said_ = true;
  progress.end();
  show(stderr, "weft: warning: obstacles or pins give way to cloth from {:.6g} s on, by {:.4g} m\n",
       report.time, report.compliance_distance);
}

/// Says once that energy comes from nothing.
void Run::warn_of_gain(Progress& progress) {
  if (gain_said_ || balance_.gain() == 0 || balance_.fatal()) return;
  gain_said_ = true;
  progress.end();
  show(
      stderr,
      "weft: warning: cloth gains energy from nothing: {:.4g} J by {:.6g} s, of which {:.4g} J are "
      "within the accuracy; a {} may help\n",
      balance_.gain(), balance_.gain_time(), balance_.bound(), shorter_steps());
}

/// Says once that cloth is strained beyond its limits.
void Run::warn_of_limits(const StepReport& report, Progress& progress) {
  if (limits_said_ || !(report.limit_excess.value_or(0) > limit_excess_max)) return;
  limits_said_ = true;
  progress.end();
  show(stderr, "weft: warning: cloth exceeds a strain limit by {:.3g} % of it at {:.6g} s\n",
       100 * *report.limit_excess, report.time);
}

bool Run::declares_compliance() const {
  const Scene& scene = simulation_.scene();
  return scene.contact.compliance_distance ||
         std::any_of(scene.obstacles.begin(), scene.obstacles.end(),
                     [](const Obstacle& o) { return o.compliance.has_value(); });
}

int Run::execute() {
  serve();
  begin();
  if (device_.choice && !device_.choice->estimates.empty()) print_choice(*device_.choice, false);
  const int frames = simulation_.scene().time.frames;
  const int every = simulation_.scene().output.checkpoint_every;
  Progress progress(stdout, frames, simulation_.scene().time.frame_rate,
                    simulation_.steps_per_frame());
  Heartbeat heartbeat(progress, [this] { return simulation_.progress(); });
  while (simulation_.frame_number() < frames && !simulation_.rest().rested) {
    if (live_ && live_->wait_while_paused()) lap();
    if (stop_requested()) {
      progress.end();
      return finish(stop_reason(), stopped);
    }
    const StepReport report = step(progress, heartbeat);
    if (report.failure != Failure::none) {
      progress.end();
      const std::string what = report.failure_detail.empty() ? "" : ": " + report.failure_detail;
      if (report.failure == Failure::stopped) return finish(stop_reason(), stopped);
      return finish(fmt::format("simulation failed at {:.6g} s (step {}): {}{}", report.time,
                                report.number, describe(report.failure), what),
                    simulation_failed, report.failure_place);
    }
    if (!frame_complete()) continue;
    if (balance_.fatal()) {
      progress.end();
      return finish_gaining();
    }
    write_frame(simulation_.frame_number());
    log_->flush();
    // Nobody should go on from a state that may be wrong.
    if (every > 0 && simulation_.frame_number() % every == 0 && !balance_.suspect())
      save_checkpoint();
  }
  progress.end();
  if (compliance_said_)
    show(stderr, "weft: warning: obstacles or pins gave way to cloth by up to {:.4g} m\n",
         totals_.compliance_distance_max);
  if (const std::string limits = totals_.exceeded_limits(); !limits.empty())
    show(stderr, "weft: warning: {}\n", limits);
  return finish_whole();
}

/// The end of a run that has done all of its frames: seams that should have closed are a failure.
/// Not where --frames says how far to go, which may be long before the scene has closed them.
int Run::finish_whole() {
  const std::vector<SeamState> seams = simulation_.seams();
  const std::string due = open_seams_text(seams, true);
  if (!due.empty() && request_.frames.empty())
    return finish(
        fmt::format("simulation failed at {:.6g} s: seam not closed: {}", simulation_.time(), due),
        simulation_failed);
  const int code = finish(std::nullopt, done);
  const std::string open = open_seams_text(seams, false);
  if (!open.empty()) show(stderr, "weft: warning: not closed at the end: {}\n", open);
  return code;
}

/// The end of a run whose cloth gains energy. Of this frame, neither the frame nor a checkpoint is
/// written.
int Run::finish_gaining() {
  gained_ = true;
  return finish(
      fmt::format("simulation failed at {:.6g} s (step {}): energy from nothing: {:.4g} J by "
                  "{:.6g} s, of which {:.4g} J are within the accuracy; a {} may help",
                  simulation_.time(), simulation_.step_number(), balance_.gain(),
                  balance_.gain_time(), balance_.bound(), shorter_steps()),
      simulation_failed);
}

/// Checkpoint, report, pictures and the last line.
/// @param place [m] of a failure, if it is known
int Run::finish(const std::optional<std::string>& failure, ExitCode code,
                const std::optional<Vec3<double>>& place) {
  if (!gained_) save_checkpoint();
  frames_.finish(code == done);
  totals_.wall += lap();
  const FrameMeshes meshes = frame_meshes(simulation_.scene(), simulation_.local_frame());
  RunFacts facts{device_,
                 validate_frame(meshes, !simulation_.scene().seams.empty()),
                 frame_complete(),
                 failure,
                 place,
                 balance_.gain()};
  const std::string report = make_report(simulation_, totals_, facts).dump(2) + "\n";
  write_file_atomically(directory_.report(), report);
  if (!request_.report.empty()) write_file_atomically(request_.report, report);
  std::optional<Vec3<double>> shown = place;
  if (shown) *shown -= meshes.origin;
  const bool picture = write_failure_picture(directory_, meshes, shown);
  if (failure)
    show(stderr, "weft: {}; checkpoint {}{}\n", *failure,
         checkpoint_.empty() ? "none" : checkpoint_.string(),
         picture ? "; picture " + directory_.failure().string() : "");
  const bool preview = draws_preview(request_) && code != stopped &&
                       write_preview(directory_, simulation_.scene(), meshes, simulation_.time());
  if (code == done) print_rest();
  if (code == done) print_summary(preview);
  if (live_) live_->end(failure.value_or("all frames are done"));
  return code;
}

void Run::print_rest() const {
  if (simulation_.scene().time.until != RunUntil::rest) return;
  const RestState rest = simulation_.rest();
  if (rest.rested)
    show(stdout, "rested at {:.6g} s, after {} frames\n", simulation_.time(),
         simulation_.frame_number());
  else
    show(stdout, "did not rest within {} frames: {:.3g} % of the vertices move, {:.3g} % may\n",
         simulation_.frame_number(), 100 * rest.moving_share, 100 * moving_share_max);
}

void Run::print_summary(bool preview) const {
  const double simulated = simulation_.time();
  show(stdout, "{}{} frames in {}{}; {} steps, {:.3g} wall s per simulated s, state {}\n",
       frames_.only_last() ? "the last of " : "", simulation_.frame_number(),
       directory_.frames().string(), preview ? ", preview " + directory_.preview().string() : "",
       simulation_.step_number(), simulated > 0 ? totals_.wall / simulated : 0.0,
       hash_text(simulation_.state_hash()));
}

/// Draws what untangling left, unless the directory holds a run that may not be replaced.
/// @return whether it could be
bool draw_tangled(const TangledStart& tangled, const RunDirectory& directory,
                  const RunRequest& request) {
  if (directory.holds_run() && !request.overwrite) return false;
  try {
    const std::unique_ptr<RunLock> lock = lock_existing(directory, request);
    directory.create();
    return write_failure_picture(directory, frame_meshes(tangled.scene(), tangled.left()),
                                 tangled.place());
  } catch (const std::exception& error) {
    show(stderr, "weft: warning: no picture of the failure: {}\n", error.what());
    return false;
  }
}

}  // namespace

int run_scene(const RunRequest& request) {
  listen_for_signals();
  const TimeLimit limit(request.time_limit);
  refuse_unwritable(request.report, "--report");
  if (request.resume_changed && request.resume.empty())
    throw SceneError("", "--resume-changed", "without --resume", "--resume with it");
  io::SceneFile file = io::read_scene_file(request.scene, overrides_of(request), request.allowed,
                                           request.experimental);
  for (const std::string& warning : file.scene.warnings)
    show(stderr, "weft: warning: {}\n", one_line(warning));
  if (request.live_port >= 0 && file.scene.method == "time_parallel")
    throw SceneError("", "--live", "the method \"time_parallel\"", "the other methods");
  if (file.scene.method == "time_parallel") return run_slices_of(request, std::move(file));
  if (const int ranks = mpi_rank_count(); ranks > 1)
    throw SceneError(
        "", "mpirun",
        std::to_string(ranks) + " processes with the method \"" + file.scene.method + "\"",
        "the method \"time_parallel\", whose slices of time they share out, or one");
  const char* beyond = request.workers > 0         ? "--workers"
                       : !request.schedule.empty() ? "--partition"
                       : request.processes         ? "--processes"
                                                   : nullptr;
  if (beyond != nullptr)
    throw SceneError("", beyond, "the method \"" + file.scene.method + "\"",
                     "the method \"time_parallel\", whose slices of time it is for");
  const RunDirectory directory(output_of(request, file.scene));
  try {
    return Run(request, std::move(file)).execute();
  } catch (const TangledStart& tangled) {
    const bool drawn = draw_tangled(tangled, directory, request);
    throw SceneError(tangled.what() +
                     (drawn ? "; picture " + directory.failure().string() : std::string()));
  }
}

void add_run_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand("run", "Simulate a scene and write its frames and report");
  auto request = std::make_shared<RunRequest>();
  subcommand->add_option("scene", request->scene, "Scene file, or the name of a shipped scene")
      ->required()
      ->type_name("SCENE");
  subcommand
      ->add_option("-o,--output", request->output,
                   "Directory of the run; default: out/<scene name>")
      ->type_name("DIR");
  subcommand->add_option("--method", request->method, "Method, instead of the scene's")
      ->type_name("M");
  subcommand
      ->add_option("--device", request->device,
                   "auto, cpu, cpu:N, cuda or cuda:0,1; default: where the run took place that is "
                   "resumed, else as the scene says, else auto: as many GPUs as pay")
      ->type_name("D");
  subcommand
      ->add_option("--precision", request->precision, "float or double, instead of the scene's")
      ->type_name("P");
  subcommand->add_option("--frames", request->frames, "How many frames, instead of the scene's")
      ->type_name("N");
  subcommand
      ->add_option("--set", request->overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  add_experimental(*subcommand, request->experimental);
  add_allow_path(*subcommand, request->allowed);
  subcommand
      ->add_option("--resume", request->resume,
                   "Go on from a checkpoint, or from the latest whole one of the directory")
      ->type_name("FILE|latest");
  subcommand->add_flag(
      "--resume-changed", request->resume_changed,
      "Resume although the scene has changed since the checkpoint; says what changed");
  subcommand->add_flag("--overwrite", request->overwrite,
                       "Replace the run that the directory holds");
  subcommand
      ->add_option("--time-limit", request->time_limit,
                   "Stop after so many seconds of wall time, as a signal would, with a checkpoint")
      ->type_name("SECONDS")
      ->check(CLI::Range(1e-3, 1e9));
  auto* live =
      subcommand
          ->add_option("--live", request->live_port,
                       "Let a browser of this machine watch, pause and stop the run; PORT of "
                       "127.0.0.1, any free one without it")
          ->type_name("[PORT]")
          ->expected(0, 1)
          ->default_str("0")
          ->check(CLI::Range(0, 65535));
  subcommand->add_option("--report", request->report, "Write the report to this file too")
      ->type_name("FILE");
  subcommand
      ->add_option("--workers", request->workers,
                   "time_parallel: slices of time that are simulated at once")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000));
  subcommand
      ->add_option("--partition", request->schedule,
                   "time_parallel: where slices begin, as an earlier run wrote it")
      ->type_name("FILE");
  subcommand->add_flag(
      "--processes", request->processes,
      "time_parallel: a process for each slice, which is replaced if it is killed");
  auto* with = subcommand->add_flag_callback(
      "--preview", [request] { request->preview = true; },
      "Draw preview.png; without this, only if the program runs in a terminal");
  auto* without = subcommand->add_flag_callback(
      "--no-preview", [request] { request->preview = false; }, "Leave preview.png out");
  with->excludes(without);
  const auto target = std::make_shared<std::string>(), chart = std::make_shared<std::string>();
  auto* wanted =
      subcommand->add_option("--need", *target,
                             "Choose settings, estimate the error, refine until it is met: "
                             "\"error<1%,intersections=0\"");
  wanted->type_name("TEXT")->excludes("--resume")->excludes(live);
  subcommand->add_option("--chart", *chart, "What weft chart has written: where --need starts")
      ->type_name("DIR")
      ->needs(wanted);
  subcommand->callback([request, target, chart, &exit_code] {
    request->scene = find_scene(request->scene);
    exit_code =
        target->empty() ? run_scene(*request) : run_to_accuracy_target(*request, *target, *chart);
  });
}

}  // namespace weft::app
