#include "weft/state/touched.hpp"

#include <gtest/gtest.h>

namespace weft {
namespace {

unsigned char after_steps(unsigned char touched, int steps, bool moved, bool jammed) {
  for (int k = 0; k < steps; ++k) touched = touched_after(touched, moved, jammed);
  return touched;
}

TEST(Touched, TellsTheLastStepFromTheLevel) {
  const unsigned char moved = touched_after(0, true, false);
  EXPECT_TRUE(was_touched(moved));
  EXPECT_EQ(touched_level(moved), 0);
  const unsigned char later = touched_after(touched_after(0, true, true), false, false);
  EXPECT_FALSE(was_touched(later));
  EXPECT_EQ(touched_level(later), level_rise - 1);
}

TEST(Touched, LevelsEndAtTheirBounds) {
  const unsigned char most = after_steps(0, 100, true, true);
  EXPECT_EQ(touched_level(most), level_max);
  EXPECT_TRUE(was_touched(most));
  EXPECT_EQ(after_steps(most, level_max, false, false), 0);
  EXPECT_EQ(after_steps(most, 100, false, false), 0);
}

TEST(Touched, EachRiseDoublesTheFactorAndItNeverFallsWithTheLevel) {
  EXPECT_EQ(hardening<double>(0), 1);
  EXPECT_EQ(hardening<double>(level_max), 128);
  for (int level = 0; level < level_max; ++level) {
    EXPECT_LT(hardening<double>(level), hardening<double>(level + 1));
    if (level + level_rise <= level_max) {
      EXPECT_EQ(hardening<float>(level + level_rise), 2 * hardening<float>(level));
    }
  }
}

}  // namespace
}  // namespace weft
