#include "weft/elements/rest_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace weft {
namespace {

constexpr Index one_cloth[4] = {0, 0, 0, 0};

/// A triangle of which two corners are at one end of a pattern and the third is at the other, and a
/// vertex in between.
TEST(RestDistance, OfAFaceAcrossASeamIsThatOfItsParts) {
  const Vec3<double> x[4] = {{5, 0.5, 0}, {0, 0, 0}, {0, 1, 0}, {8, 0.5, 0}};
  EXPECT_EQ(rest_distance_sq<1>(x, one_cloth, 0), 0);
  // Corner 2 is alone: the edges opposite the corners 0 and 1 are cut.
  EXPECT_DOUBLE_EQ(rest_distance_sq<1>(x, one_cloth, 0b011), 9);
  const Vec3<double> near[4] = {{1, 0.5, 0}, x[1], x[2], x[3]};
  EXPECT_DOUBLE_EQ(rest_distance_sq<1>(near, one_cloth, 0b011), 1);
}

TEST(RestDistance, OfCutEdgesIsThatOfTheirEnds) {
  const Vec3<double> x[4] = {{5, -1, 0}, {5, 1, 0}, {0, 0, 0}, {9, 0, 0}};
  EXPECT_EQ(rest_distance_sq<2>(x, one_cloth, 0), 0);
  EXPECT_DOUBLE_EQ(rest_distance_sq<2>(x, one_cloth, 0b10), 16);
  EXPECT_DOUBLE_EQ(rest_distance_sq<2>(x, one_cloth, 0b01), 1);
  EXPECT_DOUBLE_EQ(rest_distance_sq<2>(x, one_cloth, 0b11), 17);
}

TEST(RestDistance, IsInfiniteBetweenCloths) {
  const Vec3<double> x[4] = {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  constexpr Index other[4] = {1, 0, 0, 0};
  EXPECT_TRUE(std::isinf(rest_distance_sq<1>(x, other, 0)));
  // Of a face with one corner on the other cloth, that corner counts.
  constexpr Index corner[4] = {1, 0, 0, 1};
  EXPECT_DOUBLE_EQ(rest_distance_sq<1>(x, corner, 0b011), 1);
}

}  // namespace
}  // namespace weft
