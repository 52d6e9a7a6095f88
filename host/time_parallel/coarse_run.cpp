#include "host/time_parallel/coarse_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/temporary_file.hpp"
#include "host/scene/contact_energy.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/slice_run.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "weft/devices.hpp"

namespace weft {
namespace {

namespace fs = std::filesystem;

constexpr int bisections_max = 20;  ///< that a scene may ask for
constexpr int eases_max = 8;        ///< however much coarser the meshes are
/// Share of the energy at play that a step may gain from nothing.
constexpr double gain_max = 0.1;

/// Whether surfaces are jammed: the step has failed, or stands only as zones have moved as rigid
/// bodies. After one of those come many, each of which goes all the way down to there.
bool jammed(const StepReport& report) {
  return report.failure != Failure::none || report.fallback_level >= FallbackLevel::rigid;
}

fs::path eased_file(const fs::path& directory) {
  return directory / "eased.bin";
}

}  // namespace

std::vector<CoarseRelaxation> coarse_relaxations(const Scene& coarse) {
  const TimeParallelSettings& settings = coarse.time_parallel;
  const double most = std::max(1.0, settings.coarsening / settings.coarse_thickness);
  const int doublings = static_cast<int>(std::ceil(std::log2(most)));
  std::vector<CoarseRelaxation> eases;
  for (int k = 1; k <= std::clamp(doublings + 1, 1, eases_max); ++k)
    eases.push_back({std::min(std::exp2(k), most) * contact_thickness(coarse.contact),
                     std::min(coarse.contact.substep_bisections + k, bisections_max)});
  return eases;
}

std::vector<std::int64_t> coarse_relaxed(const fs::path& directory, std::int64_t step) {
  std::vector<std::int64_t> relaxed;
  // Beyond the state: noted by a run that was cut off before it had that one.
  for (const double from : read_work(eased_file(directory)))
    if (from <= static_cast<double>(step)) relaxed.push_back(static_cast<std::int64_t>(from));
  return relaxed;
}

CoarseRun::CoarseRun(const CoarseScene& level, fs::path directory)
    : level_(level), directory_(std::move(directory)), eases_(coarse_relaxations(level.scene)) {
  make_simulation();
  if (!CoarseStates::there(directory_, 0)) save(0);
}

/// Does not wait for the disk, which would take longer than many a coarse step: what a power cut
/// damages is made again, to the bit.
void CoarseRun::save(std::int64_t step) const {
  simulation_->save(CoarseStates::file(directory_, step), false);
}

/// @param linear takes steps with a single linear solve
void CoarseRun::make_simulation(bool linear) {
  Scene scene = level_.scene;
  if (linear) scene.solver.newton_iterations = 1;
  if (!eased_.empty()) {
    scene.contact.thickness = eases_[eased_.size() - 1].thickness;
    scene.contact.substep_bisections = eases_[eased_.size() - 1].substep_bisections;
  }
  simulation_ = std::make_unique<Simulation>(std::move(scene), host_devices(1));
}

void CoarseRun::resume(std::int64_t step) {
  eased_ = coarse_relaxed(directory_, step);
  eased_.resize(std::min(eased_.size(), eases_.size()));
  make_simulation();
  simulation_->resume(CoarseStates::file(directory_, step), SceneChanges::allow);
}

StepReport CoarseRun::take(Step& result) {
  const std::int64_t rows = cloth_rows(simulation_->scene());
  result.taken.push_back(simulation_->step());
  result.work += counted_work(result.taken.back(), rows);
  return result.taken.back();
}

/// Whether the latest step has given cloth energy that nothing put into it. Known from the states
/// at both of its ends, so that it does not matter where a run was interrupted.
bool CoarseRun::gained(const StepReport& report, const Energy& before) const {
  if (!report.work) return false;
  const Energy after = simulation_->energy();
  const double at_play = before.kinetic + before.elastic +
                         std::abs(after.gravitational - before.gravitational) +
                         std::abs(*report.work);
  return after.total() - before.total() - *report.work >
         gain_max * at_play + energy_of_contacts(simulation_->scene(), report.step);
}

/// Takes the latest step again, with a single linear solve. The run goes on from the outcome with
/// less energy.
void CoarseRun::repeat_linearly(std::int64_t number, Step& result) {
  const TemporaryFile kept(directory_ / "gained.weft");
  simulation_->save(kept.path, false);
  const double energy = simulation_->energy().total();
  make_simulation(true);
  simulation_->resume(CoarseStates::file(directory_, number - 1), SceneChanges::allow);
  const StepReport report = take(result);
  if (report.failure == Failure::none && !jammed(report) && simulation_->energy().total() < energy)
    simulation_->save(kept.path, false);
  make_simulation();
  simulation_->resume(kept.path, SceneChanges::allow);
}

CoarseRun::Step CoarseRun::step(const std::function<bool()>& stop,
                                const std::function<void(double work)>& done) {
  const std::int64_t number = simulation_->step_number() + 1;
  const std::size_t eased_before = eased_.size();
  // The last ease is for a step that fails.
  const auto may_relax = [&](const StepReport& report) {
    const std::size_t spared = report.failure != Failure::none ? 0 : 1;
    return jammed(report) && eased_.size() + spared < eases_.size();
  };
  const TemporaryFile stands(directory_ / "jammed.weft");
  Step result;
  const Energy before = simulation_->energy();
  StepReport report = take(result);
  const StepReport first = report;
  if (first.failure == Failure::none && may_relax(first)) simulation_->save(stands.path, false);
  while (may_relax(report)) {
    eased_.push_back(number);
    make_simulation();
    const std::int64_t back = std::int64_t{1} << eased_.size();
    simulation_->resume(CoarseStates::file(directory_, std::max<std::int64_t>(0, number - back)),
                        SceneChanges::allow);
    report.failure = Failure::none;
    while (simulation_->step_number() < number && report.failure == Failure::none) {
      if (stop()) return result;
      report = take(result);
    }
  }
  if (report.failure != Failure::none && first.failure == Failure::none) {
    // A state that rigid zones have moved is worse than a relaxed one, but better than none.
    eased_.resize(eased_before);
    make_simulation();
    simulation_->resume(stands.path, SceneChanges::allow);
    report = first;
  }
  result.failure = report.failure;
  result.failure_detail = report.failure_detail;
  if (report.failure != Failure::none) return result;
  if (eased_.size() == eased_before && gained(report, before)) repeat_linearly(number, result);
  done(result.work);
  if (eased_.size() > eased_before)
    write_work(eased_file(directory_), std::vector<double>(eased_.begin(), eased_.end()));
  save(number);
  result.done = true;
  return result;
}

}  // namespace weft
