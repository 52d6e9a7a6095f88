// What a step publishes, and the line that shows it.
#include "weft/step_progress.hpp"

#include <gtest/gtest.h>

#include "host/implicit/step.hpp"
#include "host/state/progress_board.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/devices.hpp"

namespace weft {
namespace {

TEST(StepProgress, EndsWithTheCountsOfTheReport) {
  const Scene scene = test::thrown_sheet(30);
  DeviceSet devices = host_devices(1);
  Store<double> store(scene, devices);
  ImplicitStep<double> step(store);
  ProgressBoard board;
  step.publish_on(board);
  int in_one_round = 0;
  for (int n = 1; n <= 12; ++n) {
    StepReport report;
    board.begin(n);
    EXPECT_EQ(board.read().zone_rounds, 0);
    step.advance(scene.time.step, report);
    const StepProgress p = board.read();
    ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
    EXPECT_EQ(p.number, n);
    EXPECT_EQ(p.stage, StepStage::detection);  // the last thing that a step does
    EXPECT_EQ(p.fallback_level, report.fallback_level);
    EXPECT_EQ(p.solves, report.solves);
    EXPECT_EQ(p.zone_work_left<1, report.zone_visits> 0);
    if (report.fallback_level == FallbackLevel::whole) {
      EXPECT_EQ(p.substep, 1);
      EXPECT_EQ(p.zone_rounds, report.zone_rounds);
    }
    if (report.zone_rounds == 0) continue;
    EXPECT_GT(p.zones, 0);
    EXPECT_LE(p.zones, report.zones);
    EXPECT_GT(p.impacts, 0);
    EXPECT_LE(p.impacts, report.impacts);
    if (report.zone_rounds == 1 && report.retries == 0) {
      ++in_one_round;
      EXPECT_EQ(p.zones, report.zones);
      EXPECT_EQ(p.impacts, report.impacts);
    }
  }
  EXPECT_GT(in_one_round, 0) << "the scene is too easy";
  board.end();
  EXPECT_EQ(board.read().number, 0);
}

/// Substeps are seen from the callback that is called at the end of each one.
TEST(StepProgress, SaysWhichPartOfTheStepIsDone) {
  Scene scene = test::thrown_sheet(20);
  scene.contact.zone_rounds = 1;
  scene.contact.substep_bisections = 12;
  DeviceSet devices = host_devices(1);
  Store<double> store(scene, devices);
  ImplicitStep<double> step(store);
  ProgressBoard board;
  step.publish_on(board);
  int parts = 0;
  for (int n = 1; n <= 12; ++n) {
    double covered = 0;
    step.watch([&](const auto&, const auto&) {
      const StepProgress p = board.read();
      EXPECT_NEAR(p.done, covered, 1e-9) << "step " << n;
      covered += p.substep;
      if (p.substep < 1) {
        ++parts;
        EXPECT_NE(p.fallback_level, FallbackLevel::whole);
      }
    });
    board.begin(n);
    StepReport report;
    step.advance(scene.time.step, report);
    ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
    EXPECT_NEAR(covered, 1, 1e-9);
  }
  EXPECT_GT(parts, 0) << "no step is done in parts";
}

TEST(StepProgress, IsALine) {
  StepProgress p;
  EXPECT_EQ(describe(p), "no step");
  p.number = 12;
  p.seconds = 63.9;
  p.stage = StepStage::solve;
  p.solves = 1;
  EXPECT_EQ(describe(p), "step 12  63 s  solve  1 solves");
  p.stage = StepStage::zones;
  p.fallback_level = FallbackLevel::halved;
  p.substep = 0.25;
  p.done = 0.5;
  p.solves = 31;
  p.zone_rounds = 7;
  p.zones = 5;
  p.impacts = 1240;
  p.zone_work_left = 0.384;
  EXPECT_EQ(describe(p),
            "step 12  63 s  impact zones  halved 1/4 at 50%  round 7: 5 zones, 1240 impacts  38% "
            "zone work left  31 solves");
  p.fallback_level = FallbackLevel::truncated;
  p.substep = 1;
  p.truncated_solves = 3;
  p.truncated_solves_left = 125;
  EXPECT_EQ(describe(p),
            "step 12  63 s  impact zones  truncated  round 7: 5 zones, 1240 impacts  38% zone work "
            "left  3 of 128 truncated solves  31 solves");
  p.stage = StepStage::windows;
  EXPECT_EQ(describe(p), "step 12  63 s  windows");
}

}  // namespace
}  // namespace weft
