#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/exec/host_devices.hpp"
#include "host/implicit/step.hpp"
#include "host/state/checkpoint.hpp"
#include "tests/support/small_scenes.hpp"

/// How stages are timed, and whether pairs are searched when they need not be, must not change a
/// bit.
namespace weft {
namespace {

constexpr int steps = 24;

struct Outcome {
  std::uint64_t hash = 0;
  std::vector<std::int64_t> waits;  ///< for each rank
  std::int64_t rebuilds = 0, zone_rounds = 0;
  int solved_again = 0;         ///< steps whose solves were repeated by certifying alone
  int fewest_searches = steps;  ///< in a step
};

/// What a step says of its stages must go with what it did, and fit into the time that it took.
void expect_sound_times(const StepReport& r, double wall) {
  EXPECT_GT(r.stages.assemble, 0);
  EXPECT_GT(r.stages.contacts, 0);
  EXPECT_GT(r.resolve_collisions.detection, 0);
  EXPECT_EQ(r.resolve_collisions.searches > 0, r.rebuilds > 0);
  EXPECT_EQ(r.resolve_collisions.zones > 0, r.zone_rounds > 0);
  if (r.active_set_iterations == 0 && r.retries == 0) {
    EXPECT_EQ(r.resolve_collisions.solves > 0, r.solves > 1);
  }
  EXPECT_LE(r.resolve_collisions.total(), wall);
  EXPECT_LE(r.stages.total(), wall);
}

Outcome run(const Scene& scene, int ranks, bool apart, bool every_step) {
  DeviceSet devices = host_devices(ranks, {true, 0});
  Store<float> store(scene, devices);
  ImplicitStep<float> step(store);
  step.time_apart(apart);
  step.search_every_step(every_step);
  Outcome out;
  for (int k = 0; k < steps; ++k) {
    StepReport report;
    const auto start = std::chrono::steady_clock::now();
    step.advance(scene.time.step, report);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(report.failure, Failure::none) << report.failure_detail;
    expect_sound_times(report, wall.count());
    out.solved_again += report.retries == 0 && report.solves > report.newton_iterations +
                                                                   report.active_set_iterations
                            ? 1
                            : 0;
    out.rebuilds += report.rebuilds;
    out.zone_rounds += report.zone_rounds;
    out.fewest_searches = std::min(out.fewest_searches, report.searches);
  }
  for (int r = 0; r < ranks; ++r) out.waits.push_back(devices[r].compute().sync_count());
  out.hash = hash_state(store.model(), store.snapshot());
  return out;
}

TEST(StageTimes, ChangeNoBits) {
  const Scene scene = test::sheet_on_sphere(Precision::single_precision);
  const Outcome plain = run(scene, 1, false, false);
  for (const int ranks : {1, 3})
    for (const bool apart : {false, true})
      for (const bool every_step : {false, true})
        EXPECT_EQ(run(scene, ranks, apart, every_step).hash, plain.hash)
            << ranks << " ranks" << (apart ? ", apart" : "") << (every_step ? ", every step" : "");
}

/// With parts that do not always occur: there must be steps with each of them.
TEST(StageTimes, GoWithWhatWasDone) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  scene.cloths[0].velocity = {0, 0, -6};
  const Outcome falling = run(scene, 3, false, false);
  EXPECT_GT(falling.zone_rounds, 0);
  EXPECT_GT(falling.rebuilds, 0);
  EXPECT_GT(falling.solved_again, 0);
}

TEST(StageTimes, ApartWaitForAllRanks) {
  const Scene scene = test::sheet_on_sphere(Precision::single_precision);
  for (const int ranks : {1, 3}) {
    const Outcome apart = run(scene, ranks, true, false), plain = run(scene, ranks, false, false);
    for (std::size_t r = 0; r < plain.waits.size(); ++r)
      EXPECT_GE(apart.waits[r], plain.waits[r] + 7 * steps) << "rank " << r << " of " << ranks;
  }
}

TEST(StageTimes, AnewSearchesInEveryStep) {
  // Nothing moves much: the pairs of a step hold in the next.
  const Scene scene = test::hanging_sheet(Precision::single_precision, Integrator::implicit_euler);
  EXPECT_EQ(run(scene, 2, false, false).fewest_searches, 0);
  EXPECT_GE(run(scene, 2, false, true).fewest_searches, 1);
}

}  // namespace
}  // namespace weft
