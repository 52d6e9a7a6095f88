#include "host/time_parallel/slice_run.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <utility>

#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

[[noreturn]] void refuse_damaged(const fs::path& file, const char* field, const char* value) {
  throw SceneError(file.string(), field, value,
                   "what the run wrote; remove the directory of the slice to compute it again");
}

void write_start_report(const fs::path& file, const SliceStart& start) {
  std::ostringstream out;
  out.precision(17);
  out << start.iterations_max << ' ' << start.iterations << ' ' << start.change << ' '
      << start.tracking_error << ' ' << start.untangled << ' ' << start.work << '\n'
      << start.note << '\n'
      << start.spin_up << ' ' << start.refused << '\n';
  write_file_atomically(file, out.str());
}

SliceStart read_start_report(const fs::path& file) {
  std::istringstream in(bytes_if_readable(file));
  SliceStart start;
  in >> start.iterations_max >> start.iterations >> start.change >> start.tracking_error >>
      start.untangled >> start.work;
  if (!in) refuse_damaged(file, "start of a slice", "damaged");
  in.ignore(1);
  std::getline(in, start.note);
  in >> start.spin_up;
  in.ignore(1);
  std::getline(in, start.refused);
  return start;
}

/// One slice from its start or its last checkpoint on.
class SliceRun {
 public:
  SliceRun(const Scene& fine, const CoarseScene& level, const SliceTask& task, DeviceSet devices,
           SliceGate& gate, SliceSink& sink)
      : level_(level),
        task_(task),
        files_(task.run, task.number),
        gate_(gate),
        sink_(sink),
        fine_(fine),
        devices_(std::move(devices)) {}

  SliceOutcome execute() {
    fs::create_directories(files_.directory());
    if (task_.number > 0 && !make_start()) return outcome_;
    begin();
    while (gate_.may_step(simulation_->step_number()))
      if (!step()) break;
    if (outcome_.failure != Failure::none) return outcome_;
    if (gate_.stopping()) {
      save(files_.checkpoint());
      return outcome_;
    }
    save(files_.end());
    outcome_.done = true;
    return outcome_;
  }

 private:
  bool make_start();
  void refuse_unless(bool fits, const fs::path& file) const;
  void begin();
  bool step();
  void save(const fs::path& file);
  bool at_frame() const { return simulation_->step_number() % simulation_->steps_per_frame() == 0; }

  const CoarseScene& level_;
  const SliceTask& task_;
  const SliceFiles files_;
  SliceGate& gate_;
  SliceSink& sink_;
  const Scene& fine_;
  DeviceSet devices_;
  std::unique_ptr<Simulation> simulation_;
  std::vector<double> work_;  ///< [steps + 1] of the slice
  SliceOutcome outcome_;
};

/// @return false: everything is to stop
bool SliceRun::make_start() {
  if (is_file(files_.start()) && is_file(files_.start_report())) {
    outcome_.start = read_start_report(files_.start_report());
    return true;
  }
  const auto start = Clock::now();
  outcome_.start =
      write_slice_start(fine_, level_, task_.first_step, SliceFiles::coarse(task_.run),
                        files_.start(), [&](double work) { return gate_.recovering(work); });
  outcome_.start_wall = seconds_since(start);
  if (!is_file(files_.start())) return false;
  write_start_report(files_.start_report(), outcome_.start);
  return true;
}

/// @throws SceneError if a state that is there is not of this slice
void SliceRun::refuse_unless(bool fits, const fs::path& file) const {
  if (fits) return;
  throw SceneError(file.string(), "step", std::to_string(simulation_->step_number()),
                   "one of the slice that begins at step " + std::to_string(task_.first_step) +
                       "; run without --resume");
}

void SliceRun::begin() {
  simulation_ = std::make_unique<Simulation>(fine_, std::move(devices_));
  if (task_.number > 0) simulation_->resume(files_.start(), SceneChanges::allow);
  refuse_unless(simulation_->step_number() == task_.first_step, files_.start());
  work_ = {outcome_.start.work};
  if (is_file(files_.checkpoint())) {
    simulation_->resume(files_.checkpoint(), SceneChanges::allow);
    refuse_unless(simulation_->step_number() >= task_.first_step, files_.checkpoint());
    work_ = read_work(files_.work());
    const auto done = static_cast<std::size_t>(simulation_->step_number() - task_.first_step);
    if (work_.size() < done + 1)
      refuse_damaged(files_.work(), "counted work", "less than the checkpoint knows of");
    work_.resize(done + 1);
  }
  outcome_.end = simulation_->step_number();
  outcome_.work = work_.back();
  sink_.begin(task_.number, simulation_->step_number(), simulation_->energy());
  if (simulation_->step_number() == 0)
    sink_.frame(0, simulation_->scene(), simulation_->local_frame());
  gate_.stepped(simulation_->step_number(), work_);
}

/// @return whether the slice goes on
bool SliceRun::step() {
  const std::int64_t rows = cloth_rows(simulation_->scene());
  const auto start = Clock::now();
  const StepReport report = simulation_->step();
  const double wall = seconds_since(start);
  outcome_.wall += wall;
  std::optional<Energy> energy;
  if (report.failure == Failure::stopped) return false;  // as if it had not begun
  const bool good = report.failure == Failure::none;
  if (good && at_frame()) energy = simulation_->energy();
  sink_.step(task_.number, report, energy, wall);
  if (!good) {
    outcome_.failure = report.failure;
    outcome_.failure_detail = report.failure_detail;
    return false;
  }
  work_.push_back(work_.back() + counted_work(report, rows));
  outcome_.work = work_.back();
  outcome_.end = simulation_->step_number();
  if (at_frame()) {
    sink_.frame(task_.number, simulation_->scene(), simulation_->local_frame());
    const int every = fine_.output.checkpoint_every;
    if (every > 0 && simulation_->frame_number() % every == 0) save(files_.checkpoint());
  }
  gate_.stepped(simulation_->step_number(), work_);
  return true;
}

void SliceRun::save(const fs::path& file) {
  sink_.sync(task_.number);
  write_work(files_.work(), work_);
  simulation_->save(file);
}

}  // namespace

SliceFiles::SliceFiles(const fs::path& run, int slice) {
  char name[16];
  std::snprintf(name, sizeof name, "%05d", slice);
  directory_ = slices(run) / name;
}

std::vector<double> read_work(const fs::path& file) {
  const std::string bytes = bytes_if_readable(file);
  std::vector<double> work(bytes.size() / sizeof(double));
  if (!work.empty()) std::memcpy(work.data(), bytes.data(), work.size() * sizeof(double));
  return work;
}

void write_work(const fs::path& file, const std::vector<double>& work, Durability durability) {
  std::string bytes(work.size() * sizeof(double), '\0');
  std::memcpy(bytes.data(), work.data(), bytes.size());
  write_file_atomically(file, bytes, durability);
}

std::optional<SliceOutcome> finished_slice(const SliceTask& task) {
  const SliceFiles files(task.run, task.number);
  if (!is_file(files.end())) return std::nullopt;
  SliceOutcome outcome;
  outcome.done = true;
  if (task.number > 0) outcome.start = read_start_report(files.start_report());
  const std::vector<double> work = read_work(files.work());
  if (work.empty()) refuse_damaged(files.work(), "counted work", "missing");
  outcome.work = work.back();
  outcome.end = task.first_step + static_cast<std::int64_t>(work.size()) - 1;
  return outcome;
}

SliceOutcome run_slice(const Scene& fine, const CoarseScene& level, const SliceTask& task,
                       DeviceSet devices, SliceGate& gate, SliceSink& sink) {
  return SliceRun(fine, level, task, std::move(devices), gate, sink).execute();
}

}  // namespace weft
