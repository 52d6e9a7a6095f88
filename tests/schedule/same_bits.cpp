#include <gtest/gtest.h>

#include "host/exec/host_devices.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr int steps = 24;

struct Outcome {
  std::uint64_t hash;
  std::int64_t impacts;
  std::int64_t proximities;
  bool good;
};

Outcome run(const Scene& scene, int ranks, std::uint64_t delay_seed, int count = steps) {
  Simulation simulation(scene, host_devices(ranks, {true, delay_seed}));
  Outcome out{0, 0, 0, true};
  for (int k = 0; k < count; ++k) {
    const StepReport r = simulation.step();
    out.impacts += r.impacts;
    out.proximities += r.proximities;
    out.good = out.good && r.failure == Failure::none;
  }
  out.hash = simulation.state_hash();
  return out;
}

void expect_same_bits(const Scene& scene, bool touches) {
  const Outcome one = run(scene, 1, 0);
  EXPECT_TRUE(one.good);
  EXPECT_EQ(touches, one.proximities > 0);
  EXPECT_NE(one.hash, run(scene, 1, 0, steps - 1).hash);
  EXPECT_EQ(one.hash, run(scene, 1, 0).hash);
  for (const int ranks : {2, 3, 5, 8})
    EXPECT_EQ(one.hash, run(scene, ranks, 0).hash) << ranks << " ranks";
}

/// The same by work queues and copies.
void expect_same_bits_pipelined(Scene scene) {
  const Outcome peer = run(scene, 1, 0);
  EXPECT_TRUE(peer.good);
  scene.solver.transport = Transport::pipelined;
  for (const int ranks : {1, 2, 3, 5, 8})
    EXPECT_EQ(peer.hash, run(scene, ranks, 0).hash) << ranks << " ranks, pipelined";
}

TEST(SameBits, SheetOnSphereFloat) {
  expect_same_bits(test::sheet_on_sphere(Precision::single_precision), true);
}
TEST(SameBits, SheetOnSphereDouble) {
  expect_same_bits(test::sheet_on_sphere(Precision::double_precision), true);
}
TEST(SameBits, TwoSheetsFloat) {
  expect_same_bits(test::two_sheets(Precision::single_precision), true);
}
TEST(SameBits, HangingSheetBdf2) {
  expect_same_bits(test::hanging_sheet(Precision::double_precision, Integrator::bdf2), false);
}

TEST(SameBits, SheetThatIsReleased) {
  expect_same_bits(test::released_sheet(Precision::single_precision), false);
}

TEST(SameBits, SheetThatIsCurvedAtRest) {
  expect_same_bits(test::curled_sheet(Precision::single_precision, Bending::plate), false);
  expect_same_bits(test::curled_sheet(Precision::double_precision, Bending::hinge), false);
}

TEST(SameBits, NewtonInTheWind) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 10);
  scene.solver.newton_iterations = 4;
  scene.wind = {1.2, {2, 1, 0}, 0.05};
  expect_same_bits(scene, true);
}
TEST(SameBits, BothLevelsOfAggregates) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision, 20);
  scene.solver.partial_rows = 128;
  expect_same_bits(scene, true);
}

TEST(SameBits, PipelinedSheetOnSphere) {
  expect_same_bits_pipelined(test::sheet_on_sphere(Precision::single_precision));
}
TEST(SameBits, PipelinedBothLevelsOfAggregates) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 20);
  scene.solver.partial_rows = 128;
  expect_same_bits_pipelined(scene);
}
TEST(SameBits, PipelinedNewtonInTheWind) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 10);
  scene.solver.newton_iterations = 4;
  scene.wind = {1.2, {2, 1, 0}, 0.05};
  expect_same_bits_pipelined(scene);
}

/// Memory starts as NaN and every piece of work is delayed by a random time: a missing copy or a
/// missing wait changes the outcome.
TEST(SameBits, ShuffledTiming) {
  const Scene scene = test::sheet_on_sphere(Precision::single_precision, 10);
  const Outcome calm = run(scene, 1, 0, 8);
  for (const int ranks : {2, 3, 8})
    for (const std::uint64_t seed : {1u, 2u})
      EXPECT_EQ(calm.hash, run(scene, ranks, seed, 8).hash) << ranks << " ranks, seed " << seed;
}

/// An iteration is some 70 pieces of work a rank here, each of which is delayed.
TEST(SameBits, ShuffledTimingPipelined) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision, 10);
  const Outcome calm = run(scene, 1, 0, 6);
  scene.solver.transport = Transport::pipelined;
  for (const int ranks : {3, 8})
    EXPECT_EQ(calm.hash, run(scene, ranks, 1, 6).hash) << ranks << " ranks";
}

}  // namespace
}  // namespace weft
