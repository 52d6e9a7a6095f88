#include "host/geometry/local_origin.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace weft {
namespace {

using Points = std::vector<Vec3<double>>;

/// Two corners of a box.
Points box(const Vec3<double>& middle, double size) {
  const Vec3<double> half{size / 2, size / 2, size / 2};
  return {middle - half, middle + half};
}

Vec3<double> origin_of(const Points& points) {
  return local_origin({&points});
}

TEST(LocalOrigin, IsZeroWithinFourSizes) {
  const Vec3<double> zero{0, 0, 0};
  EXPECT_EQ(origin_of(box({3.9, -3.9, 2}, 1)), zero);
  EXPECT_EQ(origin_of(box({39, -39, 20}, 10)), zero);
  EXPECT_NE(origin_of(box({4.1, 0, 0}, 1)), zero);
}

TEST(LocalOrigin, FollowsARoundOffset) {
  for (const Vec3<double>& offset : {Vec3<double>{0x1p20, 0, 0}, Vec3<double>{3e5, -1e5, 1e6},
                                     Vec3<double>{-400, 400, -400}, Vec3<double>{1e9, 1e9, 16}})
    for (const double at : {0.0, 0.3, -0.9, 0.999})
      EXPECT_EQ(origin_of(box(offset + Vec3<double>{at, -at, at / 2}, 1)), offset);
}

TEST(LocalOrigin, FollowsAVeryRoundOffsetFromFourSizesAway) {
  const Vec3<double> offset{0x1p20, -64, 1e6};
  EXPECT_EQ(origin_of(box(offset + Vec3<double>{3.9, -3.9, 3.9}, 1)), offset);
}

TEST(LocalOrigin, IsNearNumbersThatAreNotRound) {
  EXPECT_EQ(origin_of(box({12.555, 123456.789, -4567890.123}, 1)),
            (Vec3<double>{13, 123456, -4567890}));
}

TEST(LocalOrigin, MovesWithTheOffsetWhereItIsNotZero) {
  const Points points = box({37.3, -12.1, 5.6}, 0.5);
  const Vec3<double> offset{0x1p24, -0x1p20, 0x1p22};
  Points moved = points;
  for (auto& x : moved) x += offset;
  EXPECT_NE(origin_of(points), (Vec3<double>{0, 0, 0}));
  EXPECT_EQ(origin_of(moved), origin_of(points) + offset);
}

TEST(LocalOrigin, IsNearAnywhere) {
  for (const double far : {123456.789, -98765.4321, 7.77e8, 5e-3})
    for (int k = 0; k < 3; ++k) {
      const double size = std::min(1.0, std::abs(far) / 100);
      const Points points = box({far, far / 3, -far}, size);
      const Vec3<double> origin = origin_of(points);
      EXPECT_LE(std::abs(origin[k] - (points[0][k] + points[1][k]) / 2), 4 * size) << far;
      for (const auto& x : points) EXPECT_EQ((x[k] - origin[k]) + origin[k], x[k]) << far;
    }
}

TEST(LocalOrigin, IsZeroWithoutAPlace) {
  const Vec3<double> zero{0, 0, 0};
  EXPECT_EQ(local_origin({}), zero);
  EXPECT_EQ(origin_of({}), zero);
  EXPECT_EQ(origin_of({{1e6, 0, 0}}), zero) << "one point has no size";
  EXPECT_EQ(origin_of({{1e6, 0, 0}, {std::nan(""), 0, 0}}), zero);
  EXPECT_EQ(origin_of({{1e6, 0, 0}, {std::numeric_limits<double>::infinity(), 0, 0}}), zero);
  EXPECT_EQ(origin_of({{1e20, 1, 1}, {1e20, 1, 1.5}})[0], 0)
      << "not even doubles tell points apart";
}

TEST(LocalOrigin, MovingToTheSamePlaceTouchesNoBits) {
  Points points{{-0.0, 1, 2}};
  move_origin(points, {5, 5, 5}, {5, 5, 5});
  EXPECT_TRUE(std::signbit(points[0][0]));
  move_origin(points, {5, 0, 0}, {2, 1, 0});
  EXPECT_EQ(points[0], (Vec3<double>{3, 0, 2}));
}

}  // namespace
}  // namespace weft
