// Motions that end short of what they would run into: vertices on a line, each a point that must
// keep its order.
#include "host/implicit/collision_response/truncated_motion.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace weft {
namespace {

using Motion = TruncatedMotion<double>;
using Points = std::vector<Vec3<double>>;

/// Points that must keep their order along x, found as continuous detection finds collisions: of
/// neighbours, along straight lines.
class Line {
 public:
  Line(std::vector<double> from, std::vector<double> to, std::vector<unsigned char> held,
       TruncationKind kind = TruncationKind::rides)
      : from_(points(from)), end_(points(to)), held_(std::move(held)) {
    motion_.begin(from_, end_, held_, kind, 0.01);
  }

  /// Shortens until nothing collides.
  /// @return rounds
  int run() {
    int rounds = 0;
    for (std::vector<Collision> found = collisions(); !found.empty(); found = collisions()) {
      EXPECT_LT(rounds, Motion::rounds_max);
      if (++rounds > Motion::rounds_max) break;
      for (const auto& m : motion_.shorten({found.data(), found.size()}))
        end_[static_cast<std::size_t>(m.vertex)] = m.position;
    }
    return rounds;
  }

  double end(std::size_t v) const { return end_[v][0]; }

 private:
  static Points points(const std::vector<double>& x) {
    Points out;
    for (const double value : x) out.push_back({value, 0, 0});
    return out;
  }

  std::vector<Collision> collisions() const {
    std::vector<Collision> found;
    for (std::size_t v = 0; v + 1 < from_.size(); ++v) {
      const double before = from_[v + 1][0] - from_[v][0];
      const double after = end_[v + 1][0] - end_[v][0];
      if (after > 0.01 * before) continue;
      const auto a = static_cast<Index>(v), b = static_cast<Index>(v + 1);
      // Two edges of no length. Their second vertices weigh nothing.
      found.push_back({{b, b, a, a}, {1, 0, -1, 0}, {1, 0, 0}, 0.1, before / (before - after), 2});
    }
    return found;
  }

  Points from_, end_;
  std::vector<unsigned char> held_;
  Motion motion_;
};

TEST(TruncatedMotion, WhatMeetsNothingReachesItsTarget) {
  Line line({0, 1, 2}, {0.5, 1.5, 5}, {0, 0, 0});
  EXPECT_EQ(line.run(), 0);
  EXPECT_EQ(line.end(2), 5);
}

TEST(TruncatedMotion, FreeVerticesStopBeforeTheyMeet) {
  Line line({0, 1, 10}, {2, -1, 11}, {0, 0, 0});
  EXPECT_GT(line.run(), 0);
  EXPECT_GT(line.end(0), 0.4);  // almost half of the way, where they would meet
  EXPECT_LT(line.end(0), line.end(1));
  EXPECT_EQ(line.end(2), 11) << "is in nobody's way";
}

TEST(TruncatedMotion, PrescribedVerticesPushClothInFrontOfThem) {
  Line line({0, 0.1, 0.2, 0.3}, {5, 0.1, 0.2, 0.3}, {1, 0, 0, 0});
  EXPECT_GT(line.run(), 0);
  EXPECT_EQ(line.end(0), 5);
  for (std::size_t v = 1; v < 4; ++v) EXPECT_GT(line.end(v), line.end(v - 1));
}

TEST(TruncatedMotion, OfTwoThatPushTheFasterOneDoes) {
  Line line({0, 0.1, 0.2, 8}, {5, 0.1, 0.2, 7}, {1, 0, 0, 1});
  line.run();
  EXPECT_EQ(line.end(0), 5);
  EXPECT_EQ(line.end(3), 7);
  EXPECT_LT(line.end(2), 7);
}

TEST(TruncatedMotion, WhereThereIsNoPlacePrescribedVerticesStopToo) {
  Line line({0, 0.4, 1}, {0.8, 0.4, 0.2}, {1, 0, 1});
  line.run();
  EXPECT_LT(line.end(0), line.end(1));
  EXPECT_LT(line.end(1), line.end(2));
  EXPECT_LT(line.end(0), 0.8);
}

TEST(TruncatedMotion, PlanesLetPrescribedVerticesPushAChain) {
  Line line({0, 0.1, 0.2, 0.3, 9}, {5, 0.1, 0.2, 0.3, 9}, {1, 0, 0, 0, 0}, TruncationKind::planes);
  EXPECT_GT(line.run(), 0);
  EXPECT_EQ(line.end(0), 5);
  for (std::size_t v = 1; v < 5; ++v) EXPECT_GT(line.end(v), line.end(v - 1));
}

TEST(TruncatedMotion, PlanesKeepMostOfTheGap) {
  Line line({0, 0.4, 1}, {0.8, 0.4, 0.2}, {1, 0, 1}, TruncationKind::planes);
  line.run();
  EXPECT_GT(line.end(1) - line.end(0), 0.75 * 0.4);
  EXPECT_GT(line.end(2) - line.end(1), 0.75 * 0.6);
  EXPECT_GT(line.end(0), -1e-12) << "prescribed vertices do not go back";
  EXPECT_LT(line.end(2), 1 + 1e-12);
}

TEST(TruncatedMotion, PlanesDoNotStopMotionAlongThem) {
  // A finger and the cloth in front of it move sideways; the finger also moves into the cloth.
  Motion motion;
  const Points from{{0, 0, 0}, {0.1, 0, 0}}, to{{0.3, 2, 0}, {0.1, 2, 1}};
  motion.begin(from, to, {1, 0}, TruncationKind::planes, 0.01);
  const std::vector<Collision> found{{{1, 1, 0, 0}, {1, 0, -1, 0}, {1, 0, 0}, 0.1, 0.3, 2}};
  const auto& moved = motion.shorten({found.data(), found.size()});
  ASSERT_EQ(moved.size(), 1u);
  EXPECT_EQ(moved[0].vertex, 1);
  EXPECT_NEAR(moved[0].position[0], 0.3 + 0.8 * 0.1, 1e-12);
  EXPECT_EQ(moved[0].position[1], 2);
  EXPECT_EQ(moved[0].position[2], 1);
}

class EveryTruncation : public testing::TestWithParam<TruncationKind> {};
INSTANTIATE_TEST_SUITE_P(TruncatedMotion, EveryTruncation,
                         testing::Values(TruncationKind::planes, TruncationKind::rides,
                                         TruncationKind::shares));

TEST_P(EveryTruncation, AtWorstNothingMoves) {
  // The collisions handed over never end, whatever is shortened.
  Motion motion;
  const Points from{{0, 0, 0}, {1, 0, 0}}, to{{1, 0, 0}, {0, 0, 0}};
  motion.begin(from, to, {0, 1}, GetParam(), 0.01);
  const std::vector<Collision> always{{{0, 0, 1, 1}, {1, 0, -1, 0}, {-1, 0, 0}, 0.1, 0.5, 2}};
  Points end = to;
  for (int round = 0; round < Motion::rounds_max; ++round)
    for (const auto& m : motion.shorten({always.data(), always.size()}))
      end[static_cast<std::size_t>(m.vertex)] = m.position;
  EXPECT_EQ(end[0], from[0]);
  EXPECT_EQ(end[1], from[1]);
}

}  // namespace
}  // namespace weft
