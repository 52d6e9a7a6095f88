#include "host/render/picture_colour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::io {
namespace {

TEST(PictureColour, LightnessOfKnownColours) {
  EXPECT_NEAR(lightness({0, 0, 0}), 0, 1e-6);
  EXPECT_NEAR(lightness({1, 1, 1}), 1, 1e-5);
  EXPECT_NEAR(lightness({1, 0, 0}), 0.62796, 1e-4);  // Ottosson's table for red
  EXPECT_NEAR(lightness({0.5f, 0.5f, 0.5f}), 0.5982, 1e-3);
}

TEST(PictureColour, LightnessRisesEvenly) {
  const float low = lightness(colour_of(0)), high = lightness(colour_of(1));
  EXPECT_GT(high - low, 0.6f);
  float before = low;
  for (int i = 1; i <= 100; ++i) {
    const float t = static_cast<float>(i) / 100, now = lightness(colour_of(t));
    EXPECT_GT(now, before) << t;
    EXPECT_NEAR(now, low + t * (high - low), 0.004) << t;
    before = now;
  }
}

TEST(PictureColour, HasNoCornersThatWouldShowAsEdges) {
  Vec3<float> step{};
  for (int i = 0; i < 200; ++i) {
    const Vec3<float> next =
        colour_of(static_cast<float>(i + 1) / 200) - colour_of(static_cast<float>(i) / 200);
    EXPECT_LT(length(next), 0.02f) << i;
    if (i > 0) {
      EXPECT_LT(length(next - step), 0.006f) << i;
    }
    step = next;
  }
}

TEST(PictureColour, EndsHoldOutsideAndNoValueIsGrey) {
  EXPECT_EQ(colour_of(-3), colour_of(0));
  EXPECT_EQ(colour_of(7), colour_of(1));
  EXPECT_EQ(colour_of(std::numeric_limits<float>::infinity()), colour_of(1));
  const Vec3<float> grey = colour_of(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(grey[0], grey[1]);
  EXPECT_EQ(grey[1], grey[2]);
}

TEST(PictureColour, LightBecomesTheColourOfTheMap) {
  for (const float t : {0.0f, 0.2f, 0.5f, 0.77f, 1.0f}) {
    const Vec3<float> light = shading::mapped_light(t), colour = colour_of(t);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(std::pow(shading::filmic(light[k]), 1 / 2.2f), colour[k], 0.01) << t;
  }
}

}  // namespace
}  // namespace weft::io
