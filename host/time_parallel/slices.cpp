#include "host/time_parallel/slices.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "host/scene/camera_check.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/scene/origin.hpp"
#include "host/time_parallel/boundary_states.hpp"
#include "host/time_parallel/coarse_run.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/schedule.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Lock = std::unique_lock<std::mutex>;

/// How often those who wait look whether everything is to stop.
constexpr std::chrono::milliseconds watch{50};

/// Cuts are decided by what slices have done up to this many steps ago: the coarse run need not
/// wait for a step to end only to know that it has not ended before.
constexpr double delay_steps = 2;

double seconds(Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Lets so many work at once. Who comes before the others goes on first.
class Slots {
 public:
  explicit Slots(int count) : free_(count) {}

  /// @param lock of the mutex that all share   @param order lower ones first
  void take(Lock& lock, int order) {
    waiting_.insert(order);
    changed_.wait(lock, [&] { return free_ > 0 && *waiting_.begin() == order; });
    waiting_.erase(order);
    --free_;
    changed_.notify_all();
  }
  void leave() {
    ++free_;
    changed_.notify_all();
  }
  /// Whether someone waits who comes before.
  bool wanted(int order) const { return !waiting_.empty() && *waiting_.begin() < order; }

 private:
  int free_;
  std::set<int> waiting_;
  std::condition_variable changed_;
};

/// What all know of a slice.
struct SliceProgress {
  std::int64_t start = 0;
  std::optional<std::int64_t> end;
  std::int64_t done = -1;  ///< steps, counted from the start of the run; -1: its start is not made
  std::vector<double> work{0};  ///< [steps + 1] after recovery, which may go on, and each step
  bool over = false;
  SliceOutcome outcome;
};

/// The coarse run and all slices.
class Slices {
 public:
  Slices(const TimeParallelScene& scene, const SliceOptions& options, SliceSink& sink)
      : scene_(scene),
        options_(options),
        sink_(sink),
        slots_(options.workers),
        fine_step_(frame_step_length(scene.fine().time)),
        coarse_step_(frame_step_length(scene.coarse().scene.time)),
        least_step_(least_work(remeshes(scene.fine()) ? 1 : cloth_rows(scene.fine()))) {}

  SlicesOutcome execute();

 private:
  friend class ThreadGate;
  static constexpr int coarse_order = -1;

  void plan();
  void add_start(std::int64_t start);
  void run_coarse();
  bool step_coarse(CoarseRun& coarse);
  bool coarse_needed();
  bool as_far_as(const AdaptiveCuts& cuts) const;
  bool cut(AdaptiveCuts& cuts);
  void run_slice_thread(int number);
  SliceOutcome work_off(const SliceTask& task, SliceProgress& progress);
  bool within(std::int64_t coarse_steps, std::int64_t step) const {
    return static_cast<double>(coarse_steps) * coarse_step_ >=
           static_cast<double>(step) * fine_step_ * (1 - 1e-9);
  }
  bool reached_by_coarse(std::int64_t step) const { return within(coarse_steps_, step); }
  /// Whether a slice whose end is not known may go that far: no cut comes before it any more.
  bool open_to(std::int64_t step) const { return within(open_steps_, step); }
  bool stopping() const { return failed_ || error_ || (options_.stop && options_.stop()); }
  void fail(std::exception_ptr error) {
    if (!error_) error_ = std::move(error);
    changed_.notify_all();
  }
  template <class Ready>
  void wait(Lock& lock, int order, Ready ready);

  const TimeParallelScene& scene_;
  const SliceOptions& options_;
  SliceSink& sink_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Slots slots_;
  double fine_step_, coarse_step_;  ///< [s]
  double least_step_;               ///< counted work that no step of the fine run is below
  std::int64_t coarse_steps_ = 0;   ///< done by the coarse run
  std::int64_t open_steps_ = 0;     ///< those of them that all cuts are decided for
  bool coarse_over_ = false;
  std::vector<std::unique_ptr<SliceProgress>> slices_;
  std::vector<std::thread> threads_;
  bool all_planned_ = false;
  bool failed_ = false;  ///< a slice, or the coarse run, has met what it could not do
  std::exception_ptr error_;
  CoarseOutcome coarse_;
  std::vector<double> coarse_work_{0};   ///< [steps + 1]
  std::vector<double> coarse_clock_{0};  ///< [steps + 1] [s]
  double coarse_saving_ = 0;             ///< [s] of the latest state, for the step after it
};

/// Waits without a seat until something is so, or everything is to stop.
template <class Ready>
void Slices::wait(Lock& lock, int order, Ready ready) {
  if (ready() || stopping()) return;
  slots_.leave();
  while (!ready() && !stopping()) changed_.wait_for(lock, watch);
  slots_.take(lock, order);
}

/// Tells a slice that a thread works off how far to go.
class ThreadGate : public SliceGate {
 public:
  ThreadGate(Slices& all, int number, SliceProgress& progress)
      : all_(all), number_(number), me_(progress) {}

  bool may_step(std::int64_t done) override {
    Lock lock(all_.mutex_);
    if (all_.slots_.wanted(number_)) {  // such as the coarse run, for which others wait
      all_.slots_.leave();
      all_.slots_.take(lock, number_);
    }
    all_.wait(lock, number_, [&] { return me_.end.has_value() || all_.open_to(done + 1); });
    return !all_.stopping() && !(me_.end && done >= *me_.end);
  }
  void stepped(std::int64_t done, const std::vector<double>& work) override {
    const Lock lock(all_.mutex_);
    me_.done = done;
    me_.work = work;
    all_.changed_.notify_all();
  }
  bool recovering(double work) override {
    const Lock lock(all_.mutex_);
    me_.work = {work};
    all_.changed_.notify_all();
    return !all_.stopping();
  }
  bool stopping() override {
    const Lock lock(all_.mutex_);
    return all_.stopping();
  }

 private:
  Slices& all_;
  int number_;
  SliceProgress& me_;
};

/// A slice begins here, and the one before ends. With the mutex held.
void Slices::add_start(std::int64_t start) {
  if (!slices_.empty()) slices_.back()->end = start;
  slices_.push_back(std::make_unique<SliceProgress>());
  slices_.back()->start = start;
  if (static_cast<int>(slices_.size()) == scene_.slices()) {
    slices_.back()->end = scene_.steps();
    all_planned_ = true;
  }
  const int number = static_cast<int>(slices_.size()) - 1;
  threads_.emplace_back([this, number] { run_slice_thread(number); });
  std::vector<std::int64_t> starts;
  for (const auto& slice : slices_) starts.push_back(slice->start);
  if (options_.decided) options_.decided(starts);
  changed_.notify_all();
}

/// Starts that are known from the beginning: all, or the first.
void Slices::plan() {
  const TimeParallelSettings& settings = scene_.fine().time_parallel;
  std::vector<std::int64_t> starts{0};
  if (!options_.starts.empty())
    starts = options_.starts;
  else if (settings.schedule == TimeSchedule::uniform)
    starts = uniform_starts(scene_.steps(), scene_.slices());
  else if (settings.schedule == TimeSchedule::balanced)
    starts = balanced_starts(scene_.steps(), scene_.slices(), settings.ratio);
  const Lock lock(mutex_);
  for (const std::int64_t start : starts) add_start(start);
}

/// Whether anyone needs a state that the coarse run has not come to. With the mutex held.
bool Slices::coarse_needed() {
  if (stopping()) return false;
  if (!all_planned_) return true;
  return slices_.size() > 1 && !reached_by_coarse(slices_.back()->start);
}

/// Whether each slice has done more than the work that is looked at, or all that it may do so far.
/// With the mutex held.
bool Slices::as_far_as(const AdaptiveCuts& cuts) const {
  for (int j = 0; j <= cuts.slice(); ++j) {
    const SliceProgress& slice = *slices_[static_cast<std::size_t>(j)];
    const bool waits = slice.done >= 0 && !slice.end && !open_to(slice.done + 1);
    if (!slice.over && !waits && slice.work.back() <= cuts.work_wanted(j)) return false;
  }
  return true;
}

/// Algorithm 1, after a step of the coarse run: waits until the slices have done as much work, and
/// decides where the one under way ends.
/// @return false: everything is to stop
bool Slices::cut(AdaptiveCuts& cuts) {
  Lock lock(mutex_);
  const double work = coarse_work_.back();
  const auto reached = static_cast<std::int64_t>(
      std::floor(static_cast<double>(coarse_steps_) * coarse_step_ / fine_step_ * (1 + 1e-9)));
  cuts.advance_coarse(std::min(reached, scene_.steps()), work);
  // A step of the first slice is told from the least that it can take, until it is known. It takes
  // none before the coarse run's first one is decided on, whatever that cost.
  if (!cuts.has_delay() && work >= delay_steps * least_step_ && open_to(1)) {
    const SliceProgress& first = *slices_.front();
    wait(lock, coarse_order, [&] { return first.work.size() > 1; });
    if (stopping()) return false;
    cuts.set_delay(delay_steps * first.work[1]);
  }
  while (!cuts.complete()) {
    // All at once: a slice whose process is replaced goes back to its checkpoint.
    wait(lock, coarse_order, [&] { return as_far_as(cuts); });
    if (stopping()) return false;
    const auto done = [&](int j, double wanted) {
      return SliceDone::within(slices_[static_cast<std::size_t>(j)]->work, wanted);
    };
    if (!cuts.decide(done)) return true;
    add_start(cuts.starts().back());
  }
  return true;
}

/// @return whether the state is there
bool Slices::step_coarse(CoarseRun& coarse) {
  const fs::path directory = SliceFiles::coarse(options_.run);
  const auto start = Clock::now();
  const auto stop = [&] {
    const Lock lock(mutex_);
    return stopping();
  };
  auto counted = start;
  const CoarseRun::Step step = coarse.step(stop, [&](double work) {
    counted = Clock::now();
    const double wall = seconds(counted - start) + coarse_saving_;
    coarse_work_.push_back(coarse_work_.back() + work);
    coarse_clock_.push_back(coarse_clock_.back() + wall);
    // Without waiting for the disk, as the states.
    write_work(directory / "work.bin", coarse_work_, Durability::none);
  });
  const auto end = Clock::now();
  coarse_.wall += seconds(end - start);
  if (step.done) coarse_saving_ = seconds(end - counted);
  const Lock lock(mutex_);
  coarse_.relaxed = step.done ? coarse.relaxed() : coarse_relaxed(directory, coarse_steps_);
  if (step.failure == Failure::none) return step.done;
  coarse_.failure = step.failure;
  coarse_.failure_detail = step.failure_detail;
  failed_ = true;
  changed_.notify_all();
  return false;
}

/// The coarse run, which goes on only as far as someone needs it.
void Slices::run_coarse() {
  const fs::path directory = SliceFiles::coarse(options_.run);
  fs::create_directories(directory);
  CoarseRun coarse(scene_.coarse(), directory);
  const std::vector<double> known = read_work(directory / "work.bin");
  // Of an earlier run: states that are there need not be made again.
  const auto there = [&](std::int64_t step) {
    return static_cast<std::size_t>(step) < known.size() && CoarseStates::there(directory, step);
  };
  AdaptiveCuts cuts(scene_.steps(), scene_.slices());
  bool behind = false;  // the simulation has not made the last step itself
  const auto go_on = [&] {
    Lock lock(mutex_);
    return coarse_needed();
  };
  while (go_on()) {
    const std::int64_t next = coarse_steps_ + 1;
    if (there(next)) {
      coarse_work_.push_back(known[static_cast<std::size_t>(next)]);
      coarse_clock_.push_back(0);
      behind = true;
      coarse_.relaxed = coarse_relaxed(directory, next);
    } else {
      if (behind) coarse.resume(coarse_steps_);
      behind = false;
      if (!step_coarse(coarse)) return;
    }
    {
      const Lock lock(mutex_);
      coarse_steps_ = next;
      coarse_.steps = next;
      coarse_.work = coarse_work_.back();
      changed_.notify_all();
    }
    if (!all_planned_ && !cut(cuts)) return;
    const Lock lock(mutex_);
    open_steps_ = next;
    changed_.notify_all();
  }
}

SliceOutcome Slices::work_off(const SliceTask& task, SliceProgress& progress) {
  ThreadGate gate(*this, task.number, progress);
  if (options_.worker) return options_.worker(task, gate);
  return run_slice(scene_.fine(), scene_.coarse(), task, options_.devices(task.number), gate,
                   sink_);
}

void Slices::run_slice_thread(int number) {
  SliceProgress* me = nullptr;
  SliceTask task{number, 0, options_.run};
  bool begin = false;
  {
    Lock lock(mutex_);
    me = slices_[static_cast<std::size_t>(number)].get();
    task.first_step = me->start;
    slots_.take(lock, number);
    wait(lock, number, [&] { return number == 0 || reached_by_coarse(me->start); });
    begin = !stopping();
  }
  SliceOutcome outcome;
  std::exception_ptr error;
  if (begin) {
    try {
      const auto finished = finished_slice(task);
      outcome = finished ? *finished : work_off(task, *me);
      if (outcome.done) {  // by a process, perhaps, that was lost before it said so
        const Lock lock(mutex_);
        me->work = read_work(SliceFiles(task.run, number).work());
        me->done = outcome.end;
      }
    } catch (const StoppedError&) {
      // It has not begun, as those that wait for their start.
    } catch (...) {
      error = std::current_exception();
    }
  }
  const Lock lock(mutex_);
  outcome.end = std::max(outcome.end, task.first_step);
  me->outcome = outcome;
  me->over = outcome.done;
  if (error) fail(error);
  if (outcome.failure != Failure::none) failed_ = true;
  slots_.leave();
  changed_.notify_all();
}

SlicesOutcome Slices::execute() {
  const auto start = Clock::now();
  plan();
  {
    Lock lock(mutex_);
    slots_.take(lock, coarse_order);
  }
  try {
    run_coarse();
  } catch (...) {
    const Lock lock(mutex_);
    fail(std::current_exception());
  }
  {
    const Lock lock(mutex_);
    coarse_over_ = true;
    slots_.leave();
  }
  for (std::size_t i = 0; i < threads_.size(); ++i) threads_[i].join();
  if (error_) std::rethrow_exception(error_);
  SlicesOutcome outcome;
  outcome.steps = scene_.steps();
  outcome.coarse = coarse_;
  outcome.coarse.work_until = coarse_work_;
  outcome.coarse.wall_until = coarse_clock_;
  outcome.coarse.reached =
      std::min(scene_.steps(), static_cast<std::int64_t>(static_cast<double>(coarse_steps_) *
                                                         coarse_step_ / fine_step_ * (1 + 1e-9)));
  outcome.done = all_planned_;
  for (const auto& slice : slices_) {
    outcome.starts.push_back(slice->start);
    outcome.slices.push_back(slice->outcome);
    outcome.done = outcome.done && slice->outcome.done;
  }
  if (outcome.done) {
    const int count = static_cast<int>(slices_.size());
    const auto begin = Clock::now();
    outcome.seams.resize(slices_.size() - 1);
    for_each_seam(scene_.fine(), options_.run, count, options_.workers,
                  [&](int slice, BoundaryStates& states) {
                    const BoundarySides sides = states.at(slice);
                    outcome.seams[static_cast<std::size_t>(slice - 1)] =
                        boundary_jump(sides.scene, sides.before, sides.after);
                  });
    outcome.boundaries_wall = seconds(Clock::now() - begin);
  }
  outcome.wall = seconds(Clock::now() - start);
  return outcome;
}

}  // namespace

TimeParallelScene::TimeParallelScene(Scene scene, int slices) : fine_(std::move(scene)) {
  validate(fine_);
  choose_origin(fine_);  // one for both levels
  if (fine_.time_parallel.slices > 0) slices = fine_.time_parallel.slices;
  slices_ = slices;
  steps_ = std::int64_t{frame_steps(fine_.time)} * fine_.time.frames;
  if (slices_ < 1 || slices_ > steps_)
    throw SceneError(fine_.file, "method.time_parallel.slices",
                     std::to_string(slices_) + " slices of time",
                     "1 to the " + std::to_string(steps_) + " steps of the run");
  if (fine_.time_parallel.method == "view") refuse_camera_inside(fine_);
  if (fine_.contact.untangle) untangle_start(fine_, {});
  fine_.contact.untangle = false;
  coarse_ = make_coarse_scene(fine_);
  fine_.method = fine_.time_parallel.method;
}

void TimeParallelScene::check_starts(const std::vector<std::int64_t>& starts, bool whole) const {
  const auto refuse = [&](const std::string& value, const std::string& allowed) {
    throw SceneError(fine_.file, "partition", value, allowed);
  };
  const int count = static_cast<int>(starts.size());
  if (whole ? count != slices_ : count > slices_)
    refuse(std::to_string(starts.size()) + " starts", std::to_string(slices_) + ", one a slice");
  if (starts.front() != 0) refuse(std::to_string(starts.front()) + " as the first start", "0");
  for (std::size_t j = 1; j < starts.size(); ++j)
    if (starts[j] <= starts[j - 1] || starts[j] >= steps_)
      refuse(std::to_string(starts[j]) + " after " + std::to_string(starts[j - 1]),
             "starts that increase, below the " + std::to_string(steps_) + " steps of the run");
}

SlicesOutcome run_slices(const TimeParallelScene& scene, const SliceOptions& options,
                         SliceSink& sink) {
  if (!options.starts.empty()) scene.check_starts(options.starts);
  return Slices(scene, options, sink).execute();
}

}  // namespace weft
