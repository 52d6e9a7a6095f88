#include "weft/elements/contact.hpp"

#include <gtest/gtest.h>

#include "tests/unit/elements/configurations.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

using test::Random;

TEST(Contact, repulsion_force_is_minus_the_derivative_of_the_energy) {
  const double h = 1e-3, k = 500, step = 1e-9;
  for (double g = -2e-3; g < 2e-3; g += 1.7e-5) {
    if (std::fabs(g - h) < 2 * step) continue;
    const double slope =
        (repulsion_energy(g + step, h, k) - repulsion_energy(g - step, h, k)) / (2 * step);
    EXPECT_NEAR(repulsion_force(g, h, k), -slope, 1e-8);
  }
  EXPECT_EQ(repulsion_force(h, h, k), 0);
  EXPECT_EQ(repulsion_energy(2 * h, h, k), 0);
  EXPECT_DOUBLE_EQ(repulsion_force(0.0, h, k), 0.5);
  EXPECT_DOUBLE_EQ(repulsion_energy(0.0, h, k), 0.00025);
}

TEST(Contact, gap_is_the_signed_distance_at_the_closest_points) {
  Random random(31);
  for (int i = 0; i < 1000; ++i) {
    Vec3<double> x[4];
    const Vec3<double> offset = random.point(1000);
    for (auto& p : x) p = random.point() + offset;
    const auto p = i % 2 == 0 ? vertex_triangle(x) : edge_edge(x);
    const Vec3<double> n = contact_normal(p.difference, Vec3<double>{0, 0, 1});
    EXPECT_NEAR(length(n), 1, 1e-15);
    EXPECT_NEAR(contact_gap(n, x, p.w), std::sqrt(p.distance_sq), 4e-15);
    EXPECT_NEAR(contact_gap(-n, x, p.w), -std::sqrt(p.distance_sq), 4e-15);
    // The first primitive moves along the normal.
    Vec3<double> y[4];
    for (int j = 0; j < 4; ++j) y[j] = p.w[j] > 0 ? x[j] + n * 0.5 : x[j];
    EXPECT_NEAR(contact_gap(n, y, p.w), std::sqrt(p.distance_sq) + 0.5, 1e-12);
  }
}

// The weights of the closest points change as the corners move, and that changes no force.
TEST(Contact, repulsion_acts_on_each_corner_as_the_derivative_of_the_energy_says) {
  const double h = 4, k = 7, step = 1e-6;
  Random random(33);
  for (int i = 0; i < 400; ++i) {
    const bool edges = i % 2 == 0;
    const auto closest = [&](const Vec3<double> x[4]) {
      return edges ? edge_edge(x) : vertex_triangle(x);
    };
    Vec3<double> x[4];
    for (int j = 0; j < 4; ++j) x[j] = random.point();
    // A triangle that is all but without area (without any, the closest point has many weights),
    // and edges that meet.
    if (i % 8 >= 6) x[3] = 0.4 * x[1] + 0.6 * x[2];
    if (i % 8 == 7) x[3] += 0.01 * random.point();
    if (i % 8 < 2)  // folded flat: all in one plane
      for (auto& p : x) p[2] = 0;
    const auto p = closest(x);
    if (p.distance_sq < 1e-2) continue;
    const double gap = std::sqrt(p.distance_sq);
    const Vec3<double> n = contact_normal(p.difference, Vec3<double>{0, 0, 1});
    for (int j = 0; j < 4; ++j)
      for (int a = 0; a < 3; ++a) {
        double energy[2];
        for (const int side : {0, 1}) {
          Vec3<double> y[4] = {x[0], x[1], x[2], x[3]};
          y[j][a] += side == 0 ? -step : step;
          energy[side] = repulsion_energy(std::sqrt(closest(y).distance_sq), h, k);
        }
        EXPECT_NEAR(repulsion_force(gap, h, k) * p.w[j] * n[a],
                    -(energy[1] - energy[0]) / (2 * step), 1e-4)
            << "pair " << i << ", corner " << j << ", axis " << a;
      }
  }
}

TEST(Contact, normal_of_touching_primitives_is_the_fallback) {
  const Vec3<double> up{0, 0, 1};
  EXPECT_EQ(contact_normal(Vec3<double>{}, up), up);
  EXPECT_EQ(contact_normal(Vec3<double>{0, -3, 0}, up), (Vec3<double>{0, -1, 0}));
}

TEST(Contact, friction_scale_is_the_derivative_of_the_potential_over_y) {
  const double eps = 1e-3, step = 1e-9;
  for (double y = 1e-5; y < 3e-3; y += 1.3e-5) {
    const double slope =
        (friction_potential(y + step, eps) - friction_potential(y - step, eps)) / (2 * step);
    EXPECT_NEAR(friction_scale(y, eps) * y, slope, 1e-6);
  }
}

TEST(Contact, friction_joins_smoothly_at_eps_and_is_finite_at_rest) {
  const double eps = 1e-3;
  EXPECT_EQ(friction_potential(eps, eps), eps);
  EXPECT_NEAR(friction_potential(eps * (1 - 1e-9), eps), eps, 2e-12);
  EXPECT_NEAR(friction_scale(eps * (1 - 1e-9), eps), (1 + 1e-9) / eps, 1e-12);
  EXPECT_DOUBLE_EQ(friction_scale(eps, eps), 1 / eps);
  EXPECT_DOUBLE_EQ(friction_scale(0.0, eps), 2 / eps);
  EXPECT_DOUBLE_EQ(friction_potential(0.0, eps), eps / 3);
  EXPECT_EQ(friction_potential(5.0, eps), 5);
}

TEST(Contact, friction_force_never_exceeds_the_coulomb_limit_and_reaches_it) {
  const double mu = 0.4, fn = 3, eps = 1e-3;
  double last = 0;
  for (double y = 0; y < 5e-3; y += 1e-5) {
    const double force = friction_coefficient(mu, fn, y, eps) * y;
    EXPECT_LE(force, mu * fn * (1 + 1e-15));
    EXPECT_GE(force, last - 1e-15);
    last = force;
  }
  EXPECT_NEAR(last, 1.2, 1e-15);
}

TEST(Contact, tangential_part_is_across_the_normal) {
  Random random(32);
  for (int i = 0; i < 100; ++i) {
    const Vec3<double> n = random.unit(), u = random.point();
    const Vec3<double> t = tangential(u, n);
    EXPECT_NEAR(dot(t, n), 0, 1e-15);
    EXPECT_NEAR(length(u - t), std::fabs(dot(u, n)), 1e-15);
  }
}

}  // namespace
}  // namespace weft
