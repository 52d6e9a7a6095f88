#include "host/input/counted.hpp"

#include <gtest/gtest.h>

namespace weft {
namespace {

TEST(Counted, NounsFollowTheNumber) {
  EXPECT_EQ(counted(1, "picture"), "1 picture");
  EXPECT_EQ(counted(0, "frame"), "0 frames");
  EXPECT_EQ(counted(2u, "vertex"), "2 vertices");
  EXPECT_EQ(counted(3, "stitch"), "3 stitches");
  EXPECT_EQ(counted(1, "vertex"), "1 vertex");
}

}  // namespace
}  // namespace weft
