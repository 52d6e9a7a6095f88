// What windows promise: no pair comes closer than its layers allow, and neither window, narrow
// phase nor threads change a bit.
#include <gtest/gtest.h>

#include "tests/unit/asynchronous/brute_safety.hpp"
#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

/// Two sheets that fall on each other and on a box that rises.
Scene heap(int cells) {
  Scene s = asynchronous_scene();
  s.asynchronous.restitution = 0.3;
  s.contact.friction = 0.2;
  s.cloths.push_back(sheet(cells, 0.0));
  s.cloths.push_back(sheet(cells - 1, 0.006));
  s.cloths[1].velocity = {0.1, 0.05, -1.0};
  Obstacle o;
  o.name = "box";
  o.mesh = make_box({0.2, 0.2, 0.1}, {2, 2, 1});
  o.friction = 0.4;
  o.motion = {{0, {{0, 0, -0.056}, {0, 0, 1}, 0, 1}}, {0.2, {{0, 0, 0.04}, {0, 0, 1}, 0.5, 1}}};
  s.obstacles.push_back(o);
  return s;
}

/// A sheet that falls on its edge and folds up on the floor.
Scene folds() {
  Scene s = asynchronous_scene();
  s.asynchronous.restitution = 0;
  s.contact.friction = 0.5;
  s.cloths.push_back(sheet(7, 0.0));
  for (auto& x : s.cloths[0].mesh.positions)
    x = {0.2 * x[0] + 0.02 * x[1], x[1], 0.22 + 0.97 * x[0]};
  s.cloths[0].velocity = {0, 0, -3};
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = make_grid({2, 2}, {2, 2}, Diagonals::same);
  floor.mesh.material.clear();
  s.obstacles.push_back(floor);
  return s;
}

class SafetyOf : public testing::TestWithParam<int> {};

TEST_P(SafetyOf, NoPairComesWithinItsNextLayer) {
  WindowRun run(GetParam() == 0 ? heap(5) : folds());
  BruteSafety brute;
  brute.watch(run);
  for (int k = 1; k <= 10; ++k) ASSERT_TRUE(run.advance(0.02 * k)) << run.total.failure_detail;
  EXPECT_GT(run.total.asynchronous.rollbacks, 0) << "nothing ever met";
  EXPECT_GT(brute.tested, 1000);
  EXPECT_GE(brute.windows, 60);
  EXPECT_EQ(brute.violations, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, SafetyOf, testing::Values(0, 1));

/// Where all vertices are after a while, to the bit.
std::vector<Vec3<double>> outcome(const Scene& scene, int threads, int steps = 8) {
  WindowRun run(scene, threads);
  for (int k = 1; k <= steps; ++k) EXPECT_TRUE(run.advance(0.01 * k)) << run.total.failure_detail;
  EXPECT_GT(run.total.asynchronous.acting_pairs, 0);
  return run.positions;
}

TEST(Equivalence, WindowsChangeNoBit) {
  Scene s = heap(8);
  s.asynchronous.window = 0.003;
  const auto expected = outcome(s, 1);
  for (const double window : {0.0004, 0.01}) {
    s.asynchronous.window = window;
    EXPECT_EQ(outcome(s, 1), expected) << window;
  }
}

TEST(Equivalence, NarrowPhaseChangesNoBit) {
  Scene s = heap(8);
  const auto expected = outcome(s, 1);
  s.asynchronous.narrow = NarrowPhase::ccd;
  EXPECT_EQ(outcome(s, 1), expected);
}

TEST(Equivalence, ThreadsChangeNoBit) {
  const Scene s = heap(32);
  const auto expected = outcome(s, 1, 1);
  for (const int threads : {2, 3}) EXPECT_EQ(outcome(s, threads, 1), expected) << threads;
}

/// Windows that begin while the last one is looked at: some can go on, others cannot.
TEST(Equivalence, OptimisticStartsChangeNoBit) {
  Scene s = heap(8);
  s.asynchronous.optimistic = false;
  const auto expected = outcome(s, 1);
  EXPECT_EQ(outcome(s, 2), expected);
  s.asynchronous.optimistic = Scene().asynchronous.optimistic;
  EXPECT_TRUE(s.asynchronous.optimistic) << "as it is unless a scene says otherwise";
  s.asynchronous.window = 0.001;
  for (const int threads : {1, 2, 3, 8}) {
    WindowRun run(s, threads);
    for (int k = 1; k <= 8; ++k) ASSERT_TRUE(run.advance(0.01 * k)) << run.total.failure_detail;
    EXPECT_EQ(run.positions, expected) << threads;
    const AsynchronousCounts& c = run.total.asynchronous;
    EXPECT_EQ(c.ahead_started, c.ahead_accepted + c.ahead_cancelled);
    EXPECT_EQ(c.ahead_accepted > 0, threads > 1);
    EXPECT_EQ(c.ahead_cancelled > 0, threads > 1);
    // Each window is looked at once more than it is rolled back, the last of a step without more.
    EXPECT_EQ(c.ahead_started > 0, threads > 1);
    EXPECT_LE(c.ahead_accepted, c.windows - 8);
  }
}

/// Where detection finds something again and again they are held back, by what was counted, which
/// is the same for any number of threads; where it finds nothing they come back.
TEST(Equivalence, StartsThatAreHeldBackChangeNoBit) {
  Scene s = heap(8);
  s.asynchronous.window = 0.0005;
  std::vector<Vec3<double>> expected;
  std::int64_t held = 0;
  for (const int threads : {1, 2, 4}) {
    WindowRun run(s, threads);
    std::int64_t came_back = 0, held_before = 0, started_before = 0;
    for (int k = 1; k <= 20; ++k) {
      ASSERT_TRUE(run.advance(0.01 * k)) << run.total.failure_detail;
      const AsynchronousCounts& c = run.total.asynchronous;
      came_back += held_before > 0 && c.ahead_started > started_before ? 1 : 0;
      held_before = c.ahead_held;
      started_before = c.ahead_started;
    }
    const AsynchronousCounts& c = run.total.asynchronous;
    if (threads == 1) {
      expected = run.positions;
      EXPECT_EQ(c.ahead_started + c.ahead_held, 0) << "one thread begins nothing beside detection";
      EXPECT_EQ(run.windows.memory().ahead, 0u);
      continue;
    }
    EXPECT_EQ(run.positions, expected) << threads;
    EXPECT_GT(c.ahead_held, 0);
    EXPECT_GT(came_back, 0);
    if (threads == 2) held = c.ahead_held;
    EXPECT_EQ(c.ahead_held, held) << threads;
    EXPECT_GT(run.windows.memory().ahead, run.positions.size() * sizeof(run.positions[0]));
  }
}

TEST(StartRecord, HoldsBackWhereDetectionKeepsFindingSomething) {
  StartRecord record;
  EXPECT_TRUE(record.worthwhile());
  int found = 0;
  for (; record.worthwhile() && found < 100; ++found) record.learn(false);
  EXPECT_GT(found, 4) << "one collision is no reason";
  EXPECT_LT(found, 16);
  for (int n = 0; n < 100; ++n) record.learn(false);
  EXPECT_FALSE(record.worthwhile());
  int clear = 0;
  for (; !record.worthwhile() && clear < 100; ++clear) record.learn(true);
  EXPECT_GT(clear, 1) << "one clear window is no reason";
  EXPECT_LT(clear, 5);
  // One clear detection in two is enough, one in eight is not.
  for (int n = 0; n < 64; ++n) record.learn(n % 2 == 0);
  EXPECT_TRUE(record.worthwhile());
  for (int n = 0; n < 64; ++n) record.learn(n % 8 == 0);
  EXPECT_FALSE(record.worthwhile());
}

/// What they do, and how often they could go on, depends on no clock.
TEST(Equivalence, OptimisticStartsAreCountedAlike) {
  Scene s = heap(6);
  s.asynchronous.window = 0.001;
  std::vector<std::int64_t> first;
  for (int again = 0; again < 3; ++again) {
    WindowRun run(s, 2);
    for (int k = 1; k <= 8; ++k) ASSERT_TRUE(run.advance(0.01 * k)) << run.total.failure_detail;
    const AsynchronousCounts& c = run.total.asynchronous;
    const std::vector<std::int64_t> counts{
        c.windows,     c.rollbacks,     c.clean_windows,  c.ticks,           c.elements,
        c.layer_pairs, c.acting_pairs,  c.resimulated,    c.layers_added,    c.candidates,
        c.slabs,       c.ahead_started, c.ahead_accepted, c.ahead_cancelled, c.ahead_held};
    if (first.empty()) first = counts;
    EXPECT_EQ(counts, first);
  }
}

TEST(Safety, HoldsWithOptimisticStarts) {
  Scene s = heap(5);
  s.asynchronous.window = 0.001;
  WindowRun run(s, 2);
  BruteSafety brute;
  brute.watch(run);
  for (int k = 1; k <= 10; ++k) ASSERT_TRUE(run.advance(0.02 * k)) << run.total.failure_detail;
  EXPECT_GT(run.total.asynchronous.ahead_accepted, 0);
  EXPECT_GT(run.total.asynchronous.rollbacks, 0);
  EXPECT_EQ(brute.windows, run.total.asynchronous.windows);
  EXPECT_EQ(brute.violations, 0);
}

TEST(Caps, EndAsNamed) {
  Scene s = heap(6);
  s.asynchronous.layers = 1;
  WindowRun few(s);
  bool good = true;
  for (int k = 1; good && k <= 20; ++k) good = few.advance(0.01 * k);
  EXPECT_FALSE(good);
  EXPECT_EQ(few.total.failure, Failure::layers) << few.total.failure_detail;

  s = heap(6);
  s.asynchronous.rollbacks = 0;
  WindowRun once(s);
  good = true;
  for (int k = 1; good && k <= 20; ++k) good = once.advance(0.01 * k);
  EXPECT_FALSE(good);
  EXPECT_EQ(once.total.failure, Failure::rollbacks);

  s = heap(6);
  s.asynchronous.smallest_step = 0.9 * WindowRun(s).windows.rule().step_of(2);
  WindowRun coarse(s);
  good = true;
  for (int k = 1; good && k <= 20; ++k) good = coarse.advance(0.01 * k);
  EXPECT_FALSE(good);
  EXPECT_EQ(coarse.total.failure, Failure::small_step);
}

}  // namespace
}  // namespace weft::test
