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

/// A contact between coarse surfaces that coarse steps get along with.
struct CoarseRelaxation {
  double thickness;        ///< [m] of contacts
  int substep_bisections;  ///< of a failing step
};

/// What the coarse run takes where its steps jam, in this order. Surfaces with edges so much
/// longer, on steps so much longer, fly through a thickness that was chosen for fine ones, and what
/// repulsion does not hold jams in impact zones: up to the fine thickness times the ratio of the
/// edges, each time twice as thick, and each time one halving more; in the end once more as thick.
std::vector<CoarseRelaxation> coarse_relaxations(const Scene& coarse);

/// Steps from each of which on one more of coarse_relaxations() was in force when a run came to a
/// state.
/// @param directory of the coarse run   @param step of that state
std::vector<std::int64_t> coarse_relaxed(const std::filesystem::path& directory, std::int64_t step);

/// The run on the coarse level, of which every step leaves its state in a directory. A step that
/// fails, or in which only rigid motions of impact zones were left, is taken again from some states
/// earlier, twice as many each time, with the next of coarse_relaxations(), which then stays; the
/// last of them is kept for steps that fail. States that are there are never changed, as slices may
/// have begun with them. What is eased depends on the states alone, not on how often the run was
/// cut off.
class CoarseRun {
 public:
  /// Begins, and saves the first state unless it is there.
  /// @param level must outlive this
  CoarseRun(const CoarseScene& level, std::filesystem::path directory);

  /// Goes on from a state that is there.
  void resume(std::int64_t step);

  /// What became of a step.
  struct Step {
    bool done = false;              ///< its state is saved
    double work = 0;                ///< counted, with what failed and what was repeated
    std::vector<StepReport> taken;  ///< likewise
    Failure failure = Failure::none;
    std::string failure_detail;
  };
  /// Takes the next step.
  /// @param stop asked between repeated steps
  /// @param done told the counted work before the state is saved
  Step step(const std::function<bool()>& stop, const std::function<void(double work)>& done);

  /// As coarse_relaxed(), now.
  const std::vector<std::int64_t>& relaxed() const { return eased_; }
  const Simulation& simulation() const { return *simulation_; }

 private:
  void save(std::int64_t step) const;
  void make_simulation();
  StepReport take(Step& result);

  const CoarseScene& level_;
  std::filesystem::path directory_;
  std::vector<CoarseRelaxation> eases_;
  std::vector<std::int64_t> eased_;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace weft
