#include <gtest/gtest.h>

#include <chrono>

#include "host/implicit/step.hpp"
#include "host/scene/checkpoint.hpp"
#include "tests/support/small_scenes.hpp"

/// How stages are timed, and whether pairs are searched when they need not be, must not change a
/// bit.
namespace weft {
namespace {

constexpr int steps = 24;

struct Outcome {
  std::uint64_t hash = 0;
  std::int64_t waits = 0, rebuilds = 0, zone_rounds = 0;
  int fewest_searches = steps;  ///< in a step
};

/// What a step says of its stages must go with what it did, and fit into the time that it took.
void expect_sound_times(const StepReport& r, double wall) {
  EXPECT_GT(r.stages.assemble, 0);
  EXPECT_GT(r.stages.contacts, 0);
  EXPECT_GT(r.certify.detection, 0);
  EXPECT_EQ(r.certify.searches > 0, r.rebuilds > 0);
  EXPECT_EQ(r.certify.zones > 0, r.zone_rounds > 0);
  if (r.settles == 0 && r.retries == 0) {
    EXPECT_EQ(r.certify.solves > 0, r.solves > 1);
  }
  EXPECT_LE(r.certify.total(), wall);
  EXPECT_LE(r.stages.total(), wall);
}

Outcome run(const Scene& scene, int ranks, bool apart, bool anew) {
  DeviceSet devices = host_devices(ranks, {true, 0});
  Store<float> store(scene, devices);
  ImplicitStep<float> step(store);
  step.time_apart(apart);
  step.search_anew(anew);
  Outcome out;
  for (int k = 0; k < steps; ++k) {
    StepReport report;
    const auto start = std::chrono::steady_clock::now();
    step.advance(scene.time.step, report);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(report.failure, Failure::none) << report.failure_detail;
    expect_sound_times(report, wall.count());
    out.waits += report.synchronisations;
    out.rebuilds += report.rebuilds;
    out.zone_rounds += report.zone_rounds;
    out.fewest_searches = std::min(out.fewest_searches, report.searches);
  }
  out.hash = hash_state(store.model(), store.snapshot());
  return out;
}

TEST(StageTimes, ChangeNoBits) {
  const Scene scene = test::sheet_on_sphere(Precision::single_precision);
  const Outcome plain = run(scene, 1, false, false);
  for (const int ranks : {1, 3})
    for (const bool apart : {false, true})
      for (const bool anew : {false, true})
        EXPECT_EQ(run(scene, ranks, apart, anew).hash, plain.hash)
            << ranks << " ranks" << (apart ? ", apart" : "") << (anew ? ", anew" : "");
}

/// With parts that do not always occur: there must be steps with each of them.
TEST(StageTimes, GoWithWhatWasDone) {
  Scene scene = test::two_sheets(Precision::single_precision);
  scene.cloths[1].velocity = {0.1, 0.05, -3};
  const Outcome falling = run(scene, 3, false, false);
  EXPECT_GT(falling.zone_rounds, 0);
  EXPECT_GT(falling.rebuilds, 0);
}

TEST(StageTimes, ApartWaitForAllRanks) {
  const Scene scene = test::sheet_on_sphere(Precision::single_precision);
  for (const int ranks : {1, 3})
    EXPECT_GE(run(scene, ranks, true, false).waits,
              run(scene, ranks, false, false).waits + 7 * steps)
        << ranks << " ranks";
}

TEST(StageTimes, AnewSearchesInEveryStep) {
  // Nothing moves much: the pairs of a step hold in the next.
  const Scene scene = test::hanging_sheet(Precision::single_precision, Integrator::implicit_euler);
  EXPECT_EQ(run(scene, 2, false, false).fewest_searches, 0);
  EXPECT_GE(run(scene, 2, false, true).fewest_searches, 1);
}

}  // namespace
}  // namespace weft
