#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/time_parallel/coarse_scene.hpp"
#include "weft/report.hpp"
#include "weft/simulation.hpp"

namespace weft {

/// Contact settings with which coarse steps succeed more often.
struct CoarseRelaxation {
  double thickness;        ///< [m] of contacts
  int substep_bisections;  ///< see ContactSettings
};

/// The settings that the coarse run tries when its steps jam, in this order. With long edges and
/// long steps, surfaces pass through a contact layer that was chosen for the fine mesh, and then
/// jam in impact zones. Each entry doubles the thickness, up to the fine thickness times the ratio
/// of edge lengths, and allows one more bisection. The last entry repeats the largest thickness.
std::vector<CoarseRelaxation> coarse_relaxations(const Scene& coarse);

/// The steps at which a run switched to the next of coarse_relaxations(), up to a saved state.
/// @param directory of the coarse run
/// @param step      of that state
std::vector<std::int64_t> coarse_relaxed(const std::filesystem::path& directory, std::int64_t step);

/// The coarse run. It saves the state after each step in a directory.
///
/// A step jams if it fails, or if it succeeds only with rigid impact zones. The run then goes back
/// to an earlier state, twice as far each time, and repeats the steps with the next of
/// coarse_relaxations(). That one stays in force for the rest of the run. The last one is reserved
/// for steps that fail.
///
/// A step that gives cloth energy from nothing is repeated with a single linear solve, and the
/// outcome with less energy stays: a few iterations of Newton's method on a coarse mesh may throw
/// cloth from a body that the linear solve, which dissipates, lets it slide over.
///
/// Saved states never change, because slices may have started from them. The relaxations depend on
/// the states alone, not on how often the run was interrupted.
class CoarseRun {
 public:
  /// Starts the run, and saves the first state if the directory does not have it.
  /// @param level must outlive this
  CoarseRun(const CoarseScene& level, std::filesystem::path directory);

  /// Continues from a saved state.
  void resume(std::int64_t step);

  /// Result of one step.
  struct Step {
    bool done = false;              ///< its state is saved
    double work = 0;                ///< counted, including failed and repeated steps
    std::vector<StepReport> taken;  ///< reports of all of these steps
    Failure failure = Failure::none;
    std::string failure_detail;
  };
  /// Does the next step.
  /// @param stop called between repeated steps; true: return at once
  /// @param done called with the counted work before the state is saved
  Step step(const std::function<bool()>& stop, const std::function<void(double work)>& done);

  /// As coarse_relaxed(), for the current state.
  const std::vector<std::int64_t>& relaxed() const { return eased_; }
  const Simulation& simulation() const { return *simulation_; }

 private:
  void save(std::int64_t step) const;
  void make_simulation(bool linear = false);
  StepReport take(Step& result);
  bool gained(const StepReport& report, const Energy& before) const;
  void repeat_linearly(std::int64_t number, Step& result);

  const CoarseScene& level_;
  std::filesystem::path directory_;
  std::vector<CoarseRelaxation> eases_;
  std::vector<std::int64_t> eased_;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace weft
