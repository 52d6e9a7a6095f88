#include "host/app/new/mesh_guess.hpp"

#include <gtest/gtest.h>

namespace weft::app {
namespace {

Aabb box(const Vec3<double>& centre, const Vec3<double>& size) {
  return {centre - size * 0.5, centre + size * 0.5};
}

TEST(MeshGuess, UnitsFollowFromTheBody) {
  const Aabb shirt = box({0, 1.3, 0}, {0.6, 0.7, 0.3});
  EXPECT_EQ(guess_units(shirt, {}).value, "m");
  EXPECT_EQ(guess_units(box({}, {60, 70, 30}), {}).value, "cm");
  EXPECT_EQ(guess_units(box({}, {600, 700, 300}), {}).value, "mm");
  // A handkerchief of 9 cm alone could be 9 m.
  const Aabb small = box({0, 180, 0}, {9, 0, 9});
  EXPECT_EQ(guess_units(small, {}).value, "m");
  EXPECT_EQ(guess_units(small, box({0, 90, 0}, {60, 175, 30})).value, "cm");
  EXPECT_EQ(guess_units(small, box({0, 900, 0}, {600, 1750, 300})).value, "mm");
  EXPECT_NE(guess_units(small, box({0, 90, 0}, {60, 175, 30})).reason.find("60 x 175 x 30"),
            std::string::npos);
}

TEST(MeshGuess, UnitsThatDifferAreNoticed) {
  const Aabb shirt = box({0, 1.3, 0}, {0.6, 0.7, 0.3});
  const auto notices = [&](const Aabb& body) {
    return guess_units(shirt, body).reason.find("in another unit") != std::string::npos;
  };
  EXPECT_FALSE(notices(box({0, 0.9, 0}, {0.5, 1.8, 0.3})));
  EXPECT_TRUE(notices(box({0, 90, 0}, {50, 180, 30})));
  EXPECT_TRUE(notices(box({}, {5e-4, 1.8e-3, 3e-4})));
}

TEST(MeshGuess, TheAxisFollowsFromWhatStandsOrLies) {
  const Aabb shirt = box({0, 1.3, 0}, {0.6, 0.7, 0.3});
  EXPECT_EQ(guess_up(shirt, box({0, 0.9, 0}, {0.5, 1.8, 0.3}), ".stl").value, "y");
  EXPECT_EQ(guess_up(shirt, box({0, 0, 0.9}, {0.5, 0.3, 1.8}), ".obj").value, "z");
  const Aabb ball = box({}, {1, 1, 1});
  EXPECT_EQ(guess_up(box({0, 0.6, 0}, {1, 0, 1}), ball, ".stl").value, "y");
  EXPECT_EQ(guess_up(box({0, 0, 0.6}, {1, 1, 0}), ball, ".obj").value, "z");
  EXPECT_EQ(guess_up(box({}, {1, 0, 1}), {}, ".stl").value, "y");
  EXPECT_EQ(guess_up(box({}, {1, 1, 0}), {}, ".obj").value, "z");
  // Nothing tells: the habit of the format.
  EXPECT_EQ(guess_up(box({}, {0, 1, 1}), {}, ".obj").value, "y");
  EXPECT_EQ(guess_up(box({}, {0, 1, 1}), {}, ".stl").value, "z");
}

}  // namespace
}  // namespace weft::app
