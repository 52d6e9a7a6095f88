#include "host/app/time_parallel/time_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/process/show.hpp"
#include "host/app/process/stop_signal.hpp"
#include "host/app/run/energy_balance.hpp"
#include "host/app/run/frame_writer.hpp"
#include "host/app/run/output_folder.hpp"
#include "host/app/run/progress.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_end.hpp"
#include "host/app/run/run_output.hpp"
#include "host/app/run/run_report.hpp"
#include "host/app/time_parallel/ordered_frames.hpp"
#include "host/app/time_parallel/schedule_file.hpp"
#include "host/app/time_parallel/slice_devices.hpp"
#include "host/app/time_parallel/slice_process.hpp"
#include "host/app/time_parallel/slice_ranks.hpp"
#include "host/app/time_parallel/slice_sink.hpp"
#include "host/app/time_parallel/time_report.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/time_parallel/boundary_states.hpp"
#include "host/time_parallel/slices.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::int64_t steps_of(const Scene& scene) {
  return std::int64_t{frame_steps(scene.time)} * scene.time.frames;
}

/// A resolved scene that names the device that it is run on.
Json with_device(Json resolved, const std::string& device) {
  resolved["device"] = device;
  return resolved;
}

class TimeRun {
 public:
  /// @param ranks null: none
  TimeRun(const RunRequest& request, io::SceneFile file, SliceRanks* ranks)
      : request_(request),
        ranks_(ranks),
        devices_(request.device.empty() ? file.device : request.device),
        resolved_(with_device(std::move(file.resolved), devices_.text())),
        workers_(usual_workers(steps_of(file.scene))),
        folders_(std::move(file.folders)),
        directory_(output_folder(request.output, file.scene.name)),
        lock_(lock_unless_unfinished()),
        run_(directory_.path() / "time_parallel"),
        resuming_(!request.resume.empty() || (ranks != nullptr && left_unfinished())),
        starts_(given_starts(file.scene)),
        scene_(with_slices(std::move(file.scene)), workers_) {
    if (ranks_ != nullptr && request_.processes)
      throw SceneError("", "--processes", "with mpirun", "one of the two");
    if (!starts_.empty()) scene_.check_starts(starts_);
  }

  int execute();

 private:
  int usual_workers(std::int64_t steps) const;
  bool left_unfinished() const;
  std::vector<std::int64_t> given_starts(const Scene& scene) const;
  SliceOutcome work_off_slice(const SliceTask& task, const std::string& device, SliceGate& gate,
                              SliceSink& sink, const std::function<void()>& kept);
  const char* worker_kind() const {
    return ranks_ != nullptr ? "rank" : request_.processes ? "process" : "thread";
  }
  fs::path schedule_file() const { return directory_.path() / "partition.json"; }
  Scene with_slices(Scene scene) const;
  std::unique_ptr<RunLock> lock_unless_unfinished() const;
  void begin();
  void refuse_other_scene() const;
  void refuse_other_schedule() const;
  void write_schedule(const std::vector<std::int64_t>& starts) const;
  SlicesOutcome work_off(OrderedFrames& frames);
  int finish(const SlicesOutcome& outcome, OrderedFrames& frames);
  RunTotals join_steps(const SlicesOutcome& outcome, const Energy& start,
                       EnergyBalance& balance) const;
  double largest_frame_change(const SlicesOutcome& outcome) const;
  void write_blended(const SlicesOutcome& outcome, OrderedFrames& frames);
  bool streams() const { return scene_.fine().time_parallel.blend_frames == 0; }

  const RunRequest& request_;
  SliceRanks* ranks_;
  SliceDevices devices_;
  nlohmann::json resolved_;
  int workers_;
  std::vector<std::string> folders_;  ///< of the files that the scene names
  RunDirectory directory_;
  std::unique_ptr<RunLock> lock_;  ///< null: the directory is yet to be made
  fs::path run_;
  bool resuming_;
  std::vector<std::int64_t> starts_;  ///< given; empty: none
  TimeParallelScene scene_;
  double largest_change_ = 0;  ///< [m] of a vertex from frame to frame within slices
  std::vector<int> blended_;   ///< [seams] frames after it that were
};

/// Those that were asked for; else no more than there can be slices.
int TimeRun::usual_workers(std::int64_t steps) const {
  if (request_.workers > 0) return request_.workers;
  const int usual = ranks_ != nullptr ? mpi_rank_count() : devices_.usual_workers();
  return static_cast<int>(std::min<std::int64_t>(usual, steps));
}

/// Whether the directory holds a run of the same scene that was cut off. A rank that is lost takes
/// the others with it; the same command then goes on with what they have left.
bool TimeRun::left_unfinished() const {
  if (!ScheduleFile::read(schedule_file()) || !is_there(directory_.scene()) ||
      bytes_if_readable(directory_.scene()) != resolved_.dump(2) + "\n")
    return false;
  if (!is_there(directory_.report())) return true;
  const Json report = Json::parse(bytes_if_readable(directory_.report()), nullptr, false);
  return report.is_discarded() || report.contains("failure");
}

/// A run that was cut off, which the same command continues, is no other run.
std::unique_ptr<RunLock> TimeRun::lock_unless_unfinished() const {
  if (ranks_ != nullptr && is_folder(directory_.path()) && left_unfinished())
    return std::make_unique<RunLock>(directory_.path());
  return lock_existing(directory_, request_);
}

/// Of --partition; those of the run that is resumed.
std::vector<std::int64_t> TimeRun::given_starts(const Scene& scene) const {
  if (!request_.resume.empty() && request_.resume != "latest")
    throw SceneError("", "--resume", request_.resume,
                     "latest, with the method \"time_parallel\": it is the directory that is gone "
                     "on with");
  if (request_.schedule.empty()) return {};
  return ScheduleFile::read_whole(request_.schedule, steps_of(scene)).starts;
}

/// A given partition says how many slices there are, and so does the run that is resumed.
Scene TimeRun::with_slices(Scene scene) const {
  if (!starts_.empty()) scene.time_parallel.slices = static_cast<int>(starts_.size());
  if (!resuming_ || scene.time_parallel.slices > 0) return scene;
  const std::optional<ScheduleFile> known = ScheduleFile::read(schedule_file());
  if (!known)
    throw SceneError(directory_.path().string(), "--resume", "latest",
                     "a directory that the method \"time_parallel\" has written; it has no "
                     "partition.json, so run without --resume");
  scene.time_parallel.slices = known->slices;
  return scene;
}

/// What a resumed run has not yet followed stays: it may be stopped before it has.
void TimeRun::write_schedule(const std::vector<std::int64_t>& starts) const {
  const ScheduleFile schedule{scene_.steps(), scene_.slices(),
                              static_cast<int>(starts.size()) == scene_.slices(), starts};
  if (resuming_)
    if (const auto known = ScheduleFile::read(schedule_file());
        known && starts.size() < known->starts.size() && schedule.begins(known->starts))
      return;
  schedule.write(schedule_file());
}

/// Slices that are there are parts of one run: nothing that they depend on may change.
void TimeRun::refuse_other_scene() const {
  nlohmann::json then =
      nlohmann::json::parse(bytes_if_readable(directory_.scene()), nullptr, false);
  nlohmann::json now = resolved_;
  const auto refuse = [this](const std::string& value) {
    throw SceneError(directory_.path().string(), "--resume", value,
                     "the scene that the directory was written from");
  };
  if (!then.is_object()) refuse("a directory without a readable scene.json");
  for (auto* scene : {&then, &now})
    for (const char* key : {"device", "output"}) scene->erase(key);
  std::string changes;
  for (const auto& change : nlohmann::json::diff(then, now)) {
    std::string path = change.at("path").get<std::string>().substr(1);
    std::replace(path.begin(), path.end(), '/', '.');
    changes += (changes.empty() ? "" : ", ") + path;
    if (changes.size() > 200) {
      changes += ", and more";
      break;
    }
  }
  if (!changes.empty()) refuse("a scene with other values of " + changes);
}

/// Slices that are there begin where the run that is gone on with has begun them.
void TimeRun::refuse_other_schedule() const {
  if (starts_.empty()) return;
  const std::optional<ScheduleFile> begun = ScheduleFile::read(schedule_file());
  if (begun && !begun->begins(starts_))
    throw SceneError(directory_.path().string(), "--partition", request_.schedule,
                     "the partition that the run in this directory was begun with");
}

void TimeRun::begin() {
  const std::string text = resolved_.dump(2) + "\n";
  if (resuming_) {
    refuse_other_scene();
    refuse_other_schedule();
  }
  directory_.create();
  if (!lock_) lock_ = std::make_unique<RunLock>(directory_.path());
  if (!resuming_) {
    if (!request_.overwrite) directory_.refuse_run();
    fs::remove_all(run_);
    fs::remove(schedule_file());
  }
  directory_.clear();  // all that a run writes is made again from what slices keep
  write_file_atomically(directory_.scene(), text);
  fs::create_directories(run_);
}

SlicesOutcome TimeRun::work_off(OrderedFrames& frames) {
  std::mutex mutex;
  std::size_t count = 0;
  FrameProgress progress(stdout, static_cast<std::size_t>(scene_.fine().time.frames) + 1);
  const auto kept = [&] {
    if (streams()) frames.go_on();
    const std::lock_guard<std::mutex> lock(mutex);
    progress.frame(++count, "frames of all slices");
  };
  DiskSink sink(run_, kept);
  SliceOptions options;
  options.workers = workers_;
  options.run = run_;
  options.starts = starts_;
  options.stop = [] { return stop_requested(); };
  options.decided = [this](const std::vector<std::int64_t>& starts) { write_schedule(starts); };
  options.worker = [&](const SliceTask& task, SliceGate& gate) {
    return devices_.with_some(
        [&](const std::string& device) { return work_off_slice(task, device, gate, sink, kept); });
  };
  return run_slices(scene_, options, sink);
}

/// By whoever simulates slices. Where all ranks have one, of which some may wait, the first rank
/// takes it.
SliceOutcome TimeRun::work_off_slice(const SliceTask& task, const std::string& device,
                                     SliceGate& gate, SliceSink& sink,
                                     const std::function<void()>& kept) {
  if (request_.processes)
    return run_slice_process(directory_.scene(), folders_, device, task, gate, kept);
  SliceOutcome outcome;
  if (ranks_ != nullptr && ranks_->run(directory_.scene(), device, task, gate, kept, outcome))
    return outcome;
  return run_slice(scene_.fine(), scene_.coarse(), task, stoppable_devices(device), gate, sink);
}

/// steps.jsonl of the run, from those of its slices.
RunTotals TimeRun::join_steps(const SlicesOutcome& outcome, const Energy& start,
                              EnergyBalance& balance) const {
  RunTotals totals(start);
  std::string all;
  for (std::size_t j = 0; j < outcome.slices.size(); ++j)
    all += read_steps(DiskSink::steps(run_, static_cast<int>(j)),
                      std::numeric_limits<std::int64_t>::max(), [&](const StepLine& line) {
                        totals.add(line);
                        balance.add(line.report, line.energy);
                      });
  write_file_atomically(directory_.steps(), all);
  return totals;
}

/// Largest motion of a vertex from one frame to the next, where no seam is in between. [m]
double TimeRun::largest_frame_change(const SlicesOutcome& outcome) const {
  const std::int64_t per_frame = frame_steps(scene_.fine().time);
  const Scene& fine = scene_.fine();
  double most = 0;
  KeptFrame last;
  for (int n = 0; n <= fine.time.frames; ++n) {
    KeptFrame kept = read_kept_frame(DiskSink::frame_file(run_, n));
    const bool across =
        std::any_of(outcome.starts.begin() + 1, outcome.starts.end(),
                    [&](std::int64_t s) { return (n - 1) * per_frame <= s && s < n * per_frame; });
    if (n > 0 && !across)
      most = std::max(most, largest_move(frame_on(last.frame, last.cloth_meshes_in(fine),
                                                  kept.cloth_meshes_in(fine)),
                                         kept.frame));
    last = std::move(kept);
  }
  return most;
}

/// Spreads jumps beyond the tolerance over the frames after their seams. A frame that would then
/// intersect stays as it is.
void TimeRun::write_blended(const SlicesOutcome& outcome, OrderedFrames& frames) {
  const TimeParallelSettings& settings = scene_.fine().time_parallel;
  const double step = frame_step_length(scene_.fine().time);
  const double length = settings.blend_frames / scene_.fine().time.frame_rate;
  blended_.assign(outcome.seams.size(), 0);
  std::vector<std::optional<std::pair<Frame, Frame>>> seams(outcome.seams.size());
  BoundaryStates states(scene_.fine(), run_);
  for (std::size_t j = 0; j < seams.size(); ++j)
    if (outcome.seams[j].position > settings.boundary_tolerance * largest_change_) {
      BoundarySides sides = states.at(static_cast<int>(j) + 1);
      seams[j].emplace(std::move(sides.before), std::move(sides.after));
    }
  frames.go_on([&](Frame frame) {
    for (std::size_t j = seams.size(); j-- > 0;) {
      const double since = frame.time - static_cast<double>(outcome.starts[j + 1]) * step;
      if (!(since > 1e-9 * step)) continue;
      // Only the seam that the frame's own slice begins with.
      const double t = since / length;
      if (!seams[j] || t >= 1) break;
      Frame changed = blended(frame, seams[j]->first, seams[j]->second, 1 - t * t * (3 - 2 * t));
      if (!free_of_intersections(scene_.fine(), changed)) break;
      ++blended_[j];
      return changed;
    }
    return frame;
  });
}

int TimeRun::execute() {
  begin();
  OrderedFrames frames(directory_, scene_.fine(), run_);
  return finish(work_off(frames), frames);
}

std::optional<std::string> failure_of(const SlicesOutcome& outcome) {
  const auto text = [](const std::string& who, Failure failure, const std::string& detail) {
    return fmt::format("simulation failed in {}: {}{}", who, describe(failure),
                       detail.empty() ? "" : ": " + detail);
  };
  if (outcome.coarse.failure != Failure::none)
    return text(fmt::format("the coarse run (its step {})", outcome.coarse.steps + 1),
                outcome.coarse.failure, outcome.coarse.failure_detail);
  for (std::size_t j = 0; j < outcome.slices.size(); ++j)
    if (outcome.slices[j].failure != Failure::none)
      return text(fmt::format("slice {} (step {})", j, outcome.slices[j].end + 1),
                  outcome.slices[j].failure, outcome.slices[j].failure_detail);
  if (!outcome.done) return stop_reason();
  return std::nullopt;
}

int TimeRun::finish(const SlicesOutcome& outcome, OrderedFrames& frames) {
  if (outcome.done) largest_change_ = largest_frame_change(outcome);
  if (outcome.done && !streams()) write_blended(outcome, frames);
  frames.go_on();
  frames.finish(outcome.done);
  const auto failure = failure_of(outcome);
  const ExitCode code = outcome.done ? done : stop_requested() ? stopped : simulation_failed;
  Simulation last(scene_.fine(), host_devices(1));
  const Energy start = last.energy();
  EnergyBalance balance(scene_.fine(), start);
  RunTotals totals = join_steps(outcome, start, balance);
  totals.wall = outcome.wall;
  const int slices = static_cast<int>(outcome.slices.size());
  const fs::path end = SliceFiles(run_, slices - 1).end();
  if (outcome.done) last.resume(end, SceneChanges::allow);
  const FrameMeshes meshes = frame_meshes(last.scene(), last.local_frame());
  RunFacts facts{{devices_.text(), {}},
                 validate_frame(meshes, false, last.scene().contact.self),
                 outcome.done,
                 failure,
                 {},
                 balance.gain()};
  Json report = make_report(last, totals, facts);
  report["method"] = "time_parallel";
  report["time_parallel"] =
      time_report(scene_, outcome, {workers_, worker_kind(), largest_change_, blended_});
  const std::string text = report.dump(2) + "\n";
  write_file_atomically(directory_.report(), text);
  if (!request_.report.empty()) write_file_atomically(request_.report, text);
  if (failure) show(stderr, "weft: {}; what is done is in {}\n", *failure, run_.string());
  if (code != done) return code;
  warn_of_intersections(facts.verdict, directory_);
  if (balance.gain() > 0) show(stderr, "weft: warning: {}\n", balance.gain_text());
  if (const std::string limits = totals.exceeded_limits(); !limits.empty())
    show(stderr, "weft: warning: {}\n", limits);
  const bool preview =
      draws_preview(request_) && write_preview(directory_, last.scene(), meshes, last.time());
  show(stdout, "{} in {}{}; {}, {}, {:.3g} wall s per simulated s, state {}\n",
       counted(frames.count() - 1, "frame"), directory_.frames().string(),
       preview ? ", preview " + directory_.preview().string() : "", counted(slices, "slice"),
       counted(last.step_number(), "step"), totals.wall / std::max(last.time(), 1e-300),
       hash_text(last.state_hash()));
  return code;
}

}  // namespace

int run_slices_of(const RunRequest& request, io::SceneFile file) {
  if (request.resume_changed)
    throw SceneError("", "--resume-changed", "the method \"time_parallel\"",
                     "another method: slices are parts of one run");
  refuse_uncounted_ranks();
  if (mpi_rank_count() == 1) return TimeRun(request, std::move(file), nullptr).execute();
  SliceRanks ranks;
  if (ranks.first()) return TimeRun(request, std::move(file), &ranks).execute();
  ranks.serve(file.folders);
  return done;
}

}  // namespace weft::app
