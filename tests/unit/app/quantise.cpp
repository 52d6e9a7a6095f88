// Positions in 16 bits, values in 8, bytes as text. Linked with the program's own objects, see
// tests/CMakeLists.txt.
#include "host/app/view/quantise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace weft::app {
namespace {

std::uint16_t step_at(const std::string& bytes, std::size_t number) {
  return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[2 * number]) |
                                    static_cast<unsigned char>(bytes[2 * number + 1]) << 8);
}

TEST(LargestError, IsHalfAStepOfTheLongestSide) {
  Aabb box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(largest_error(box), 0);
  box = aabb_of({{1, -2, 3}, {-1, 5, 3}});
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.lo, (Vec3<double>{-1, -2, 3}));
  EXPECT_EQ(box.hi, (Vec3<double>{1, 5, 3}));
  EXPECT_DOUBLE_EQ(largest_error(box), 7.0 / 65535 / 2);
}

TEST(AppendPositions, ComeBackWithinHalfAStep) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(-3, 2), y(1000, 1001), z(-1e-3, 1e-3);
  std::vector<Vec3<double>> positions;
  for (int i = 0; i < 1000; ++i) positions.push_back({x(random), y(random), z(random)});
  Aabb box;
  box = aabb_of(positions);
  std::string bytes;
  append_positions(bytes, positions, box);
  ASSERT_EQ(bytes.size(), 6u * 1000);
  std::size_t number = 0;
  for (const Vec3<double>& p : positions)
    for (int k = 0; k < 3; ++k) {
      const double back = stored_coordinate(step_at(bytes, number++), box.lo[k], box.hi[k]);
      EXPECT_NEAR(back, p[k], (box.hi[k] - box.lo[k]) / 65535 / 2 * (1 + 1e-6));
    }
}

TEST(AppendPositions, EndsOfTheBoxAreExact) {
  Aabb box;
  box = aabb_of({{0, 0, 5}, {1, 2, 5}});
  std::string bytes;
  append_positions(bytes, {{0, 2, 5}, {1, 0, 5}, {-9, 9, 5}}, box);
  EXPECT_EQ(step_at(bytes, 0), 0);
  EXPECT_EQ(step_at(bytes, 1), 65535);
  EXPECT_EQ(step_at(bytes, 2), 0) << "a flat box has no steps";
  EXPECT_EQ(step_at(bytes, 3), 65535);
  EXPECT_EQ(step_at(bytes, 6), 0) << "outside";
  EXPECT_EQ(step_at(bytes, 7), 65535) << "outside";
}

TEST(AppendLevels, EndsAreKeptAndWhatIsNoNumberStandsOut) {
  std::string bytes;
  append_levels(bytes, {-1, 0, 0.5f, 1, 7, std::nanf(""), std::numeric_limits<float>::infinity()},
                0, 1);
  std::vector<int> levels;
  for (const char c : bytes) levels.push_back(static_cast<unsigned char>(c));
  EXPECT_EQ(levels, (std::vector<int>{0, 0, 127, 254, 254, 255, 254}));
}

// Test vectors of RFC 4648, section 10.
TEST(Base64, IsThatOfTheStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string("\xff\xef\x00", 3)), "/+8A");
}

}  // namespace
}  // namespace weft::app
