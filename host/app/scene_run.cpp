#include "host/app/scene_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "host/app/process/show.hpp"
#include "host/app/process/stop_signal.hpp"
#include "host/app/run/output_folder.hpp"
#include "host/app/run/seam_verdict.hpp"
#include "host/base/atomic_file.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A checkpoint that a run goes on from, and the directory whose steps.jsonl it continues.
struct Origin {
  fs::path file;
  bool same_directory = false;
  bool renumbered = false;  ///< its steps and frames have other numbers than those of this run
  std::vector<std::string> warnings{};  ///< to be said once the run goes on
};

/// Of a cloth's weight: what attached edges bear of it is said from this share on.
constexpr double borne_share_named = 0.01;

/// Resumes from a checkpoint; with --resume-changed from that of another scene too.
Origin resume_from(Simulation& simulation, const fs::path& file, const RunRequest& request) {
  const auto changes =
      simulation.resume(file, request.resume_changed ? SceneChanges::allow : SceneChanges::refuse);
  Origin origin{file};
  for (const std::string& change : changes) {
    origin.warnings.push_back(file.string() + ": resumed although " + change);
    origin.renumbered = origin.renumbered || change.starts_with("time.");
  }
  return origin;
}

/// Takes over the newest checkpoint that is whole.
/// @throws SceneError if there is none
Origin resume_latest(Simulation& simulation, const RunDirectory& directory,
                     const RunRequest& request) {
  const auto files = directory.checkpoints();
  if (files.empty())
    throw SceneError(directory.path().string(), "--resume", "latest",
                     std::string("a directory with a checkpoint; it has none, so run ") +
                         (directory.holds_run() ? "with --overwrite instead of" : "without") +
                         " --resume");
  std::optional<SceneError> first;
  for (const auto& file : files) {
    try {
      Origin origin = resume_from(simulation, file, request);
      origin.same_directory = true;
      if (first)
        origin.warnings.push_back(
            fmt::format("{}; resuming from {}", first->what(), file.string()));
      return origin;
    } catch (const SceneError& error) {
      if (!first) first = error;
    }
  }
  throw *first;
}

}  // namespace

std::string output_of(const RunRequest& request, const Scene& scene) {
  return output_folder(request.output, scene.name).string();
}

/// [s] since the last call
double SceneRun::lap() {
  const auto now = Clock::now();
  const std::chrono::duration<double> seconds = now - lap_start_;
  lap_start_ = now;
  return seconds.count();
}

/// Touches the disk only once the scene, and the checkpoint if any, are known to be good.
void SceneRun::make_directory() {
  directory_.create();
  if (!lock_) lock_ = std::make_unique<RunLock>(directory_.path());
}

void SceneRun::begin_from_checkpoint() {
  Origin origin;
  if (request_.resume == "latest") {
    origin = resume_latest(simulation_, directory_, request_);
  } else {
    origin = resume_from(simulation_, request_.resume, request_);
    std::error_code error;
    origin.same_directory =
        fs::equivalent(fs::absolute(origin.file).parent_path(), directory_.path(), error);
  }
  if (origin.renumbered && origin.same_directory)
    throw SceneError("", "--resume-changed",
                     "another time step or frame rate in the same directory",
                     "another directory, with -o: frames and steps have other numbers now");
  if (const int frames = simulation_.scene().time.frames; simulation_.frame_number() > frames)
    throw SceneError("", request_.frames.empty() ? "time.frames" : "--frames",
                     std::to_string(frames),
                     fmt::format("at least {}, as many frames as {} has",
                                 simulation_.frame_number(), origin.file.string()));
  const fs::path steps = fs::absolute(origin.file).parent_path() / "steps.jsonl";
  const std::string kept = origin.renumbered ? ""
                                             : read_steps(steps, simulation_.step_number(),
                                                          [this](const StepLine& line) {
                                                            totals_.add(line);
                                                            balance_.add(line.report, line.energy);
                                                          });
  if (origin.renumbered || request_.resume_changed) balance_.restart(simulation_.energy());
  if (totals_.steps < simulation_.step_number())
    origin.warnings.push_back(fmt::format(
        "{} lacks {} of the {} before the checkpoint; the report leaves them out", steps.string(),
        simulation_.step_number() - totals_.steps, counted(simulation_.step_number(), "step")));
  if (!origin.same_directory && !request_.overwrite) directory_.refuse_run();
  make_directory();
  for (const std::string& warning : origin.warnings)
    show(stderr, "weft: warning: {}\n", one_line(warning));
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

void SceneRun::begin() {
  if (!request_.resume.empty()) {
    begin_from_checkpoint();
  } else {
    make_directory();
    if (!request_.overwrite) directory_.refuse_run();
    directory_.clear();
    log_ = std::make_unique<StepLog>(directory_.steps(), "");
    start_ = std::make_shared<const std::string>(simulation_.state());
    write_frame(0);
  }
  // Whoever reads this scene again, or goes on from here, is to take the same devices.
  resolved_["device"] = device_.text;
  write_file_atomically(directory_.scene(), resolved_.dump(2) + "\n");
}

void SceneRun::write_frame(int number) {
  const Scene& scene = simulation_.scene();
  // A job must be a value that can be copied.
  const auto meshes =
      std::make_shared<const FrameMeshes>(frame_meshes(scene, simulation_.local_frame()));
  if (live_) live_->add_frame(number, simulation_.time(), *meshes);
  writing_.add([this, meshes, number] { frames_.write(*meshes, number); });
}

/// Lets a browser of this machine watch.
void SceneRun::serve() {
  if (request_.live_port < 0) return;
  live_ = std::make_unique<LiveServer>(request_.live_port, simulation_.scene(), device_.text);
  show(stdout, "watch the run at {}\n", live_->address());
  std::fflush(stdout);
}

/// The steps and frames first: a checkpoint must never know more than they.
void SceneRun::save_checkpoint() {
  log_->flush();
  writing_.add([this] {
    log_->sync();
    frames_.sync();
  });
  if (checkpoint_step_ == simulation_.step_number()) return;
  checkpoint_ = directory_.checkpoint(simulation_.frame_number());
  checkpoint_step_ = simulation_.step_number();
  const auto state = std::make_shared<const std::string>(simulation_.state());
  start_.reset();
  writing_.add([this, file = checkpoint_, state] { directory_.save_checkpoint(file, *state); });
}

StepReport SceneRun::step(Progress& progress, Heartbeat& heartbeat) {
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
void SceneRun::warn_of_compliance(const StepReport& report, Progress& progress) {
  if (compliance_said_ || report.compliance_distance <= 0 ||
      !simulation_.scene().contact.compliance_distance)
    return;
  compliance_said_ = true;
  progress.end();
  show(stderr, "weft: warning: obstacles or pins give way to cloth from {:.6g} s on, by {:.4g} m\n",
       report.time, report.compliance_distance);
}

/// Says once that energy comes from nothing.
void SceneRun::warn_of_gain(Progress& progress) {
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
void SceneRun::warn_of_limits(const StepReport& report, Progress& progress) {
  if (limits_said_ || !(report.limit_excess.value_or(0) > limit_excess_max)) return;
  limits_said_ = true;
  progress.end();
  show(stderr, "weft: warning: cloth exceeds a strain limit by {:.3g} % of it at {:.6g} s\n",
       100 * *report.limit_excess, report.time);
}

/// Says which garments springs close, and why.
void SceneRun::print_garments() const {
  for (const GarmentStart& start : simulation_.scene().garment_starts) {
    if (start.start != SewnStart::springs) continue;
    const std::string& name =
        simulation_.scene().cloths[static_cast<std::size_t>(start.cloth)].name;
    show(start.reason.empty() ? stdout : stderr,
         "{}{}: springs close its seams, without gravity until then{}\n",
         start.reason.empty() ? "" : "weft: warning: ", name,
         start.reason.empty() ? "" : ", because welded it cannot be parted: " + start.reason);
  }
}

int SceneRun::execute() {
  serve();
  print_garments();
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
int SceneRun::finish_whole() {
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
/// written; if there is no checkpoint yet, one of the start is.
int SceneRun::finish_gaining() {
  gained_ = true;
  if (start_) {
    checkpoint_ = directory_.checkpoint(0);
    writing_.add(
        [this, file = checkpoint_, state = start_] { directory_.save_checkpoint(file, *state); });
  }
  return finish(
      fmt::format("simulation failed at {:.6g} s (step {}): energy from nothing: {:.4g} J by "
                  "{:.6g} s, of which {:.4g} J are within the accuracy; a {} may help",
                  simulation_.time(), simulation_.step_number(), balance_.gain(),
                  balance_.gain_time(), balance_.bound(), shorter_steps()),
      simulation_failed);
}

/// Checkpoint, report, pictures and the last line.
/// @param place [m] of a failure, if it is known
int SceneRun::finish(const std::optional<std::string>& failure, ExitCode code,
                     const std::optional<Vec3<double>>& place) {
  if (!gained_) save_checkpoint();
  writing_.wait();
  frames_.finish(code == done);
  totals_.wall += lap();
  const FrameMeshes meshes = frame_meshes(simulation_.scene(), simulation_.local_frame());
  RunFacts facts{
      device_,
      validate_frame(meshes, !simulation_.scene().seams.empty(), simulation_.scene().contact.self),
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
  if (gain_said_ && !gained_) show(stderr, "weft: warning: {}\n", balance_.gain_text());
  warn_of_intersections(facts.verdict, directory_);
  if (failure)
    show(stderr, "weft: {}; checkpoint {}{}\n", *failure,
         checkpoint_.empty() ? "none" : checkpoint_.string(),
         picture ? "; picture " + directory_.failure().string() : "");
  const bool preview = draws_preview(request_) && code != stopped &&
                       write_preview(directory_, simulation_.scene(), meshes, simulation_.time());
  if (code == done) print_rest();
  if (code == done) print_attachments();
  if (code == done) print_summary(preview);
  if (live_) live_->end(failure.value_or("all frames are done"));
  return code;
}

void SceneRun::print_rest() const {
  if (simulation_.scene().time.until != RunUntil::rest) return;
  const RestState rest = simulation_.rest();
  if (rest.rested)
    show(stdout, "rested at {:.6g} s, after {}\n", simulation_.time(),
         counted(simulation_.frame_number(), "frame"));
  else
    show(
        stdout,
        "did not rest within {}: {:.3g} % of the vertices move, {:.3g} % may; {:.3g} % of them get "
        "somewhere, {:.3g} % may\n",
        counted(simulation_.frame_number(), "frame"), 100 * rest.moving_share,
        100 * moving_share_max, 100 * rest.displaced_share, 100 * displaced_share_max);
}

/// Cloth at rest may hang from what held it at the start.
void SceneRun::print_attachments() const {
  if (simulation_.scene().garment_starts.empty()) return;
  for (const HandleState& handle : simulation_.handles())
    if (handle.weight_share >= borne_share_named)
      show(stdout,
           "attached edges of \"{}\" bear {:.3g} % of its weight; \"end_time\" lets them go\n",
           handle.cloth, 100 * handle.weight_share);
}

void SceneRun::print_summary(bool preview) const {
  const double simulated = simulation_.time();
  show(stdout, "{}{} in {}{}; {}, {:.3g} wall s per simulated s, state {}\n",
       frames_.only_last() ? "the last of " : "", counted(simulation_.frame_number(), "frame"),
       directory_.frames().string(), preview ? ", preview " + directory_.preview().string() : "",
       counted(simulation_.step_number(), "step"), simulated > 0 ? totals_.wall / simulated : 0.0,
       hash_text(simulation_.state_hash()));
}

}  // namespace weft::app
