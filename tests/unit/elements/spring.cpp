#include "weft/elements/spring.hpp"

#include <gtest/gtest.h>

#include "tests/unit/elements/configurations.hpp"

namespace weft {
namespace {

using test::Random;

constexpr double k = 700;

TEST(Spring, ForceAndStiffnessAreDerivativesOfTheEnergy) {
  Random random(11);
  const double step = 1e-5;
  for (int n = 0; n < 300; ++n) {
    const double rest = n % 3 == 0 ? 0 : random.uniform(0, 0.5);
    const Vec3<double> d = random.uniform(0.6, 2) * random.unit();
    const Vec3<double> force = spring_force(d, rest, k);
    const Mat3<double> stiffness = spring_stiffness(d, rest, k);
    for (int c = 0; c < 3; ++c) {
      Vec3<double> up = d;
      Vec3<double> down = d;
      up[c] += step;
      down[c] -= step;
      const double slope = (spring_energy(up, rest, k) - spring_energy(down, rest, k)) / (2 * step);
      EXPECT_NEAR(force[c], -slope, 1e-6 * k);
      const Vec3<double> change =
          (1 / (2 * step)) * (spring_force(up, rest, k) - spring_force(down, rest, k));
      for (int r = 0; r < 3; ++r) EXPECT_NEAR(stiffness(r, c), -change[r], 1e-6 * k);
    }
  }
}

TEST(Spring, IsSlackUpToItsRestLength) {
  const Vec3<double> d{0.03, 0.04, 0};
  EXPECT_EQ(spring_energy(d, 0.051, k), 0);
  EXPECT_EQ(length(spring_force(d, 0.051, k)), 0);
  for (const double entry : spring_stiffness(d, 0.051, k).e) EXPECT_EQ(entry, 0);
  EXPECT_NEAR(length(spring_force(d, 0.04, k)), 0.01 * k, 1e-12);
}

TEST(Spring, OfNoLengthAtRestHasAFiniteStiffnessWhereItsEndsMeet) {
  const Vec3<double> none{0, 0, 0};
  EXPECT_EQ(length(spring_force(none, 0.0, k)), 0);
  const Mat3<double> stiffness = spring_stiffness(none, 0.0, k);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(stiffness(r, c), r == c ? k : 0);
}

}  // namespace
}  // namespace weft
