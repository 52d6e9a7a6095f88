#include "host/geometry/triangle_pair.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "host/base/random.hpp"

namespace weft {
namespace {

Vec3<double> random_point(std::uint64_t& state, double height) {
  const double x = next_random(state), y = next_random(state);
  return {x, y, height * next_random(state)};
}

/// Two triangles with one common corner have another point in common where the edge opposite it of
/// one runs through the other, and nowhere else; pierces() is exact.
TEST(TrianglePair, OfOneCommonCornerMeetWhereAnOppositeEdgePierces) {
  std::uint64_t state = 11;
  for (const double height : {1.0, 0.1, 1e-3}) {
    int meeting = 0, apart = 0;
    for (int k = 0; k < 4000; ++k) {
      const Vec3<double> p = random_point(state, height);
      const Vec3<double> a = random_point(state, height), b = random_point(state, height);
      const Vec3<double> c = random_point(state, height), d = random_point(state, height);
      // The common corner comes first in one and last in the other.
      const Corners s{p, a, b}, t{c, d, p};
      const bool meet = pierces(a, b, t) || pierces(c, d, s);
      EXPECT_EQ(triangles_intersect({{0, 1, 2}}, {{3, 4, 0}}, s, t), meet);
      EXPECT_EQ(triangles_intersect({{3, 4, 0}}, {{0, 1, 2}}, t, s), meet);
      ++(meet ? meeting : apart);
    }
    EXPECT_GT(meeting, 400);
    EXPECT_GT(apart, 400);
  }
}

/// The same corners under numbers that differ are two points at one place, which touch.
TEST(TrianglePair, AtOnePlaceWithoutACommonNumberTouch) {
  const Corners s{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}};
  const Corners t{{{0, 0, 0}, {-1, 0, 0}, {-1, -1, 0}}};
  EXPECT_TRUE(triangles_intersect({{0, 1, 2}}, {{3, 4, 5}}, s, t));
  EXPECT_FALSE(triangles_intersect({{0, 1, 2}}, {{0, 4, 5}}, s, t));
}

TEST(TrianglePair, FoldedOntoEachOtherAboutACornerTouch) {
  const Corners s{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}};
  const Corners t{{{0, 0, 0}, {2, 0.5, 0}, {0.5, 2, 0}}};
  EXPECT_TRUE(triangles_intersect({{0, 1, 2}}, {{0, 3, 4}}, s, t));
}

TEST(TrianglePair, PlainlyApartByLessThanTheirDistanceOnly) {
  const Corners s{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Corners t{{{0, 0, 0.25}, {1, 0, 0.25}, {0, 1, 0.25}}};
  EXPECT_TRUE(plainly_apart(s, t, 0.249));
  EXPECT_FALSE(plainly_apart(s, t, 0.25));
}

}  // namespace
}  // namespace weft
