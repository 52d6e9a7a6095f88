// What chords tell of ways: bounds that hold, and that are of use.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "host/asynchronous/gap.hpp"
#include "host/asynchronous/histories.hpp"

namespace weft::test {
namespace {

constexpr double span = 1e-3;  // [s] of a window

/// Four vertices, three of cloth, that go by random breakpoints.
struct RandomTrajectories {
  Histories trajectories;
  VertexMotion motion;

  RandomTrajectories(std::mt19937& random, double speed, double shake) {
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3<double>{unit(random), unit(random), unit(random)}; };
    for (int i = 0; i < 4; ++i) motion.x.push_back(vector());
    motion.v.assign(4, {});
    motion.t.assign(4, 0);
    trajectories.reset(motion, 3, 0);
    Vec3<double> along[4];
    for (Vec3<double>& a : along) a = vector() * speed;
    for (int k = 1; k <= 10; ++k) {
      const double time = span * k / 10;
      for (std::size_t i = 0; i < 4; ++i)
        motion.x[i] += along[i] * 0.1 + vector() * (shake * speed);
      motion.t.assign(4, time);
      if (k == 10) break;
      if (k % 2 == 0) {
        Vec3<double>* const breakpoints = trajectories.add_all(time);
        std::copy_n(motion.x.begin(), 3, breakpoints);
      }
      for (std::size_t i = 0; i < 4; ++i)
        if (i == 3 || k % 2 != 0) trajectories.add(i, time, motion.x[i]);
    }
    trajectories.finish(motion, span);
  }
};

TEST(Chords, ReachAsFarAsTheirWays) {
  std::mt19937 random(5);
  for (int n = 0; n < 200; ++n) {
    const RandomTrajectories made(random, 0.3, 0.1);
    Chord chords[4];
    made.trajectories.chords(0, 4, chords);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::vector<Breakpoint> way = made.trajectories.way(i);
      ASSERT_GE(way.size(), 8u);
      double deviation = 0;
      for (const Breakpoint& k : way)
        deviation = std::max(
            deviation,
            length(k.x - (chords[i].from + (chords[i].to - chords[i].from) * (k.t / span))));
      EXPECT_EQ(chords[i].from, way.front().x);
      EXPECT_EQ(chords[i].to, way.back().x);
      EXPECT_GT(deviation, 0);
      EXPECT_NEAR(chords[i].deviation, deviation, 1e-15);
      Chord alone;
      made.trajectories.chords(i, i + 1, &alone);
      EXPECT_EQ(alone.deviation, chords[i].deviation);
    }
  }
}

/// Against the distance at many moments of the window.
TEST(Gap, IsNeverMoreThanTheDistance) {
  std::mt19937 random(9);
  int of_use = 0;
  const int tried = 1000;
  for (int n = 0; n < tried; ++n) {
    const RandomTrajectories made(random, std::pow(10.0, -(n % 4)), 0.1);
    const PrimitivePair pair{PrimitivePair::key_of(n % 2 == 0, 0, 1), {0, 1, 2, 3}};
    Chord chords[4];
    made.trajectories.chords(0, 4, chords);
    const Chord* const corners[4] = {chords, chords + 1, chords + 2, chords + 3};
    std::vector<Breakpoint> trajectories[4];
    for (std::size_t i = 0; i < 4; ++i) trajectories[i] = made.trajectories.way(i);
    double least = 10, approach = 0;
    Vec3<double> x[4];
    for (int k = 0; k <= 200; ++k) {
      for (int c = 0; c < 4; ++c) x[c] = position_at(Trajectory(trajectories[c]), span * k / 200);
      const Proximity<double> p = pair.closest(x);
      least = std::min(least, std::sqrt(p.distance_sq));
      Vec3<double> way{};
      for (int c = 0; c < 4; ++c) way += (chords[c].to - chords[c].from) * p.w[c];
      approach = std::max(approach, length(way));
    }
    const double gap = least_gap(pair, corners);
    EXPECT_LE(gap, least * (1 + 1e-12)) << n;
    EXPECT_LE(approach, most_approach(pair, corners) * (1 + 1e-12)) << n;
    if (gap > 0.5 * least) ++of_use;
  }
  EXPECT_GT(of_use, tried / 2);
}

/// Corners in one point: no direction, and nothing is known.
TEST(Gap, SaysNothingOfPairsThatTouch) {
  const Chord here{{0.3, 0.2, 0.1}, {0.3, 0.2, 0.1}};
  const Chord* const corners[4] = {&here, &here, &here, &here};
  for (const bool edges : {true, false})
    EXPECT_LE(least_gap({PrimitivePair::key_of(edges, 0, 1), {0, 1, 2, 3}}, corners), 0);
}

}  // namespace
}  // namespace weft::test
