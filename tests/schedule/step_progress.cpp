// The progress of a step, read by another thread while the step runs.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <set>
#include <thread>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// What a reader has seen of one step at a time.
struct Seen {
  std::set<StepStage> stages;
  FallbackLevel deepest = FallbackLevel::whole;
  std::int64_t last = 0;  ///< number of a step
  int rounds_max = 0, zones_max = 0, truncated_solves_max = 0;
  double substep_min = 1, done_max = 0, work_left_min = 1;
  int out_of_range = 0;
  int backwards = 0;  ///< steps or counts that went down

  void add(const StepProgress& p) {
    if (p.number == 0) return;
    if (p.number < last || (p.number == last && p.zone_rounds + 1 < rounds_)) ++backwards;
    last = p.number;
    rounds_ = p.zone_rounds;
    stages.insert(p.stage);
    deepest = std::max(deepest, p.fallback_level);
    rounds_max = std::max(rounds_max, p.zone_rounds);
    zones_max = std::max(zones_max, p.zones);
    truncated_solves_max = std::max(truncated_solves_max, p.truncated_solves);
    substep_min = std::min(substep_min, p.substep);
    done_max = std::max(done_max, p.done);
    work_left_min = std::min(work_left_min, p.zone_work_left);
    const bool good = p.seconds >= 0 && p.seconds < 600 && p.substep > 0 && p.substep <= 1 &&
                      p.done >= 0 && p.done <= 1 && p.zone_work_left >= 0 &&
                      p.zone_work_left <= 1 && p.solves >= 0 && p.zones >= 0 && p.impacts >= 0 &&
                      p.truncated_solves + p.truncated_solves_left <= 128;
    out_of_range += good ? 0 : 1;
  }

 private:
  int rounds_ = 0;
};

TEST(StepProgress, IsReadFromAnotherThreadAndChangesNoBit) {
  const Scene scene = test::folded_napkin(Precision::single_precision);
  Simulation alone(scene, host_devices(1));
  Simulation simulation(scene, host_devices(2));
  EXPECT_EQ(simulation.progress().number, 0);
  std::atomic<bool> end{false};
  Seen seen;
  std::thread reader([&] {
    while (!end) {
      seen.add(simulation.progress());
      std::this_thread::yield();
    }
  });
  int rounds = 0, zones = 0;
  bool truncated = false;
  for (int n = 0; n < 12; ++n) {
    const StepReport report = simulation.step();
    EXPECT_EQ(simulation.progress().number, 0) << "between two steps";
    alone.step();
    rounds = std::max(rounds, report.zone_rounds);
    zones = std::max(zones, report.zones);
    truncated = truncated || report.fallback_level == FallbackLevel::truncated;
  }
  end = true;
  reader.join();
  EXPECT_EQ(alone.state_hash(), simulation.state_hash());
  EXPECT_TRUE(truncated) << "the scene is too easy";
  EXPECT_EQ(seen.out_of_range, 0);
  EXPECT_EQ(seen.backwards, 0);
  EXPECT_GT(seen.last, 6);
  EXPECT_EQ(seen.deepest, FallbackLevel::truncated);
  EXPECT_GT(seen.truncated_solves_max, 0);
  EXPECT_LT(seen.substep_min, 1);
  EXPECT_GT(seen.done_max, 0);
  EXPECT_LT(seen.work_left_min, 1);
  EXPECT_GT(seen.rounds_max, 0);
  EXPECT_LE(seen.rounds_max, rounds + 1);
  EXPECT_GT(seen.zones_max, 0);
  EXPECT_LE(seen.zones_max, zones);
  for (const StepStage stage : {StepStage::contacts, StepStage::solve, StepStage::detection,
                                StepStage::zones, StepStage::truncation})
    EXPECT_TRUE(seen.stages.contains(stage)) << describe(stage);
}

}  // namespace
}  // namespace weft
