#include "weft/elements/spring.hpp"

#include <gtest/gtest.h>

#include "tests/unit/elements/configurations.hpp"

namespace weft {
namespace {

using test::Long;
using test::Random;

constexpr double k = 700;

/// A unit vector across d; any, if that is zero.
Vec3<double> tangential_to(const Vec3<double>& d, Random& random) {
  const double size_sq = length_sq(d);
  const Vec3<double> u = random.unit();
  const Vec3<double> across = size_sq > 0 ? u - d * (dot(u, d) / size_sq) : u;
  return (1 / length(across)) * across;
}

struct Case {
  const char* name;
  double length, rest;  ///< [m]
};

/// Where derivatives exist; at the rest length itself the stiffness jumps.
constexpr Case cases[] = {
    {"stretched", 0.9, 0.4},
    {"by a lot", 100, 0.01},
    {"barely", 0.4 * (1 + 1e-4), 0.4},
    {"of no length at rest", 0.7, 0},
    {"of no length at rest, nearly there", 1e-12, 0},
    {"of no length at rest, there", 0, 0},
    {"nearly of no length at rest", 2e-9, 1e-9},
    {"slack", 0.2, 0.4},
    {"barely slack", 0.4 * (1 - 1e-4), 0.4},
    {"slack, its ends at one place", 0, 0.4},
};

TEST(Spring, ForceAndStiffnessAreDerivativesOfTheEnergy) {
  Random random(11);
  for (const Case& c : cases)
    for (int n = 0; n < 50; ++n) {
      SCOPED_TRACE(c.name);
      const Vec3<double> d[1] = {c.length * random.unit()};
      const Long rest = c.rest;
      // Short against the length, and against the way to where the spring is slack.
      const double room = c.rest > 0 ? std::fabs(c.length - c.rest) : 1;
      const Long step = c.length > 0 && c.rest > 0 ? 0.01 * std::fmin(room, c.length) : 1e-3;
      const auto energy = [&](const Vec3<Long>(&x)[1]) {
        return spring_energy(x[0], rest, static_cast<Long>(k));
      };
      const auto gradient = [&](const Vec3<Long>(&x)[1], Vec3<Long>(&g)[1]) {
        g[0] = -spring_force(x[0], rest, static_cast<Long>(k));
      };
      Vec3<double> expected[1];
      test::difference_gradient(energy, d, step, expected);
      const Vec3<double> force[1] = {-spring_force(d[0], c.rest, k)};
      EXPECT_LE(test::largest_difference(force, expected), 1e-7 * k * std::fmax(c.length, 1e-3));
      Mat3<double> change[1][1];
      test::difference_hessian(gradient, d, step, change);
      const Mat3<double> stiffness[1][1] = {{spring_stiffness(d[0], c.rest, k)}};
      EXPECT_LE(test::largest_difference(stiffness, change), 1e-6 * k);
    }
}

TEST(Spring, StiffnessIsSemidefinite) {
  Random random(12);
  for (const Case& c : cases)
    for (int n = 0; n < 20; ++n) {
      const Vec3<double> d = c.length * random.unit();
      const Mat3<double> m = spring_stiffness(d, c.rest, k);
      for (int r = 0; r < 3; ++r)
        for (int q = 0; q < r; ++q) EXPECT_EQ(m(r, q), m(q, r)) << c.name;
      // k along it, and k (1 - rest / length), or nothing, across
      const Vec3<double> across = tangential_to(d, random);
      EXPECT_GE(dot(across, m * across), -1e-12 * k) << c.name;
      EXPECT_GE(dot(d, m * d), 0) << c.name;
      EXPECT_LE(dot(across, m * across), k * (1 + 1e-12)) << c.name;
    }
}

TEST(Spring, GuidedResistsOnlyAlongItsDirection) {
  Random random(13);
  for (int n = 0; n < 50; ++n) {
    const Vec3<double> along = random.unit();
    const Vec3<Long> guide = vec_cast<Long>(along);
    const Vec3<double> d[1] = {(0.002 * n) * random.unit()};
    const auto energy = [&](const Vec3<Long>(&x)[1]) {
      return spring_energy(spring_span(x[0], guide), Long(0), static_cast<Long>(k));
    };
    const auto gradient = [&](const Vec3<Long>(&x)[1], Vec3<Long>(&g)[1]) {
      g[0] = -spring_force(spring_span(x[0], guide), Long(0), static_cast<Long>(k));
    };
    const double height = dot(along, d[0]);
    EXPECT_NEAR(static_cast<double>(energy({vec_cast<Long>(d[0])})), k / 2 * height * height,
                1e-12 * k);
    const Long step = 1e-3;
    Vec3<double> expected[1];
    test::difference_gradient(energy, d, step, expected);
    const Vec3<double> force[1] = {-spring_force(spring_span(d[0], along), 0.0, k)};
    EXPECT_LE(test::largest_difference(force, expected), 1e-8 * k);
    Mat3<double> change[1][1];
    test::difference_hessian(gradient, d, step, change);
    const Mat3<double> stiffness[1][1] = {{spring_stiffness(d[0], 0.0, k, along)}};
    EXPECT_LE(test::largest_difference(stiffness, change), 1e-8 * k);
    EXPECT_LE(length(stiffness[0][0] * tangential_to(along, random)), 1e-12 * k);
  }
  // Without a direction, nothing is left out.
  const Vec3<double> d{0.03, 0.04, 0}, none{0, 0, 0};
  EXPECT_EQ(spring_span(d, none), d);
  EXPECT_EQ(spring_stiffness(d, 0.04, k, none).e[1], spring_stiffness(d, 0.04, k).e[1]);
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
