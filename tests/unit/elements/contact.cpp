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

TEST(Contact, friction_is_the_derivative_of_its_potential) {
  const double k = 40, limit = 0.03, step = 1e-9;
  for (double y = 1e-5; y < 3e-3; y += 1.3e-5) {
    const double slope =
        (friction_potential(k, limit, y + step) - friction_potential(k, limit, y - step)) /
        (2 * step);
    EXPECT_NEAR(friction_drag(k, limit, y) * y, slope, 1e-8);
  }
}

/// Displacements sticking and sliding, from none at all to a thousand times what sticks, and on
/// either side of the limit.
TEST(Contact, friction_and_its_tangent_are_derivatives_of_the_potential) {
  Random random(34);
  const double k = 40, limit = 1.2;
  for (const double share : {0.0, 1e-9, 0.3, 0.999, 1.001, 2.0, 1e3})
    for (int n = 0; n < 50; ++n) {
      SCOPED_TRACE(share);
      const double reach = limit / k;
      const Vec3<test::Real> u[1] = {share * reach * random.unit()};
      const test::Long step = 1e-4 * reach;
      const auto energy = [&](const Vec3<test::Long>(&x)[1]) {
        return friction_potential<test::Long>(k, limit, length(x[0]));
      };
      const auto gradient = [&](const Vec3<test::Long>(&x)[1], Vec3<test::Long>(&g)[1]) {
        g[0] = friction_force(friction_tangent<test::Long>(k, limit, x[0]), x[0]);
      };
      const auto tangent = friction_tangent(k, limit, u[0]);
      const Vec3<double> force[1] = {friction_force(tangent, u[0])};
      Vec3<double> expected[1];
      test::difference_gradient(energy, u, step, expected);
      EXPECT_LE(test::largest_difference(force, expected), 1e-10 * limit);
      // Within the friction's own direction nothing changes any more: the matrix lacks it.
      const Mat3<double> matrix[1][1] = {
          {tangent.stiffness * (Mat3<double>::identity() - outer(tangent.slide, tangent.slide))}};
      Mat3<double> change[1][1];
      test::difference_hessian(gradient, u, step, change);
      EXPECT_LE(test::largest_difference(matrix, change), 1e-9 * k);
      const Vec3<double> any = random.unit();
      EXPECT_GE(dot(any, matrix[0][0] * any), -1e-15 * k);
    }
}

TEST(Contact, friction_without_a_normal_force_is_none) {
  Random random(35);
  for (const double size : {1e-9, 1.0}) {
    const Vec3<double> u = size * random.unit();
    const auto tangent = friction_tangent(40.0, 0.0, u);
    EXPECT_EQ(tangent.stiffness, 0);
    EXPECT_EQ(friction_force(tangent, u), (Vec3<double>{}));
  }
}

TEST(Contact, friction_sticks_like_a_spring_up_to_the_limit_and_keeps_to_it) {
  const double k = 40, limit = 1.2;
  EXPECT_EQ(friction_drag(k, limit, 0.0), k);
  EXPECT_EQ(friction_drag(k, 0.0, 0.0), k);  // nothing to resist
  EXPECT_EQ(friction_drag(k, 0.0, 1e-9), 0);
  EXPECT_EQ(friction_drag(k, limit, limit / k), k);
  double last = 0;
  for (double y = 0; y < 0.1; y += 1e-4) {
    const double force = friction_drag(k, limit, y) * y;
    EXPECT_LE(force, limit * (1 + 1e-15));
    EXPECT_GE(force, last - 1e-15);
    last = force;
  }
  EXPECT_NEAR(last, limit, 1e-15);
}

TEST(Contact, what_exceeds_the_limit_slides) {
  const double k = 40, limit = 1.2;
  const Vec3<double> sticking{0.01, 0.02, 0};
  EXPECT_EQ(anchor_after(sticking, k, limit), sticking);
  const Vec3<double> sliding{3, 0, -4};
  const Vec3<double> left = anchor_after(sliding, k, limit);
  EXPECT_NEAR(k * length(left), limit, 1e-15);
  EXPECT_NEAR(length(cross(left, sliding)), 0, 1e-15);
  EXPECT_GT(dot(left, sliding), 0);
  EXPECT_EQ(anchor_after(sliding, k, 0.0), (Vec3<double>{}));
}

TEST(Contact, anchor_turns_with_its_normal) {
  Random random(33);
  for (int i = 0; i < 200; ++i) {
    const Vec3<double> before = random.unit();
    const Vec3<double> anchor = tangential(random.point(), before);
    EXPECT_EQ(length(turned_anchor(anchor, before, before) - anchor) < 1e-15, true);
    Vec3<double> after = random.unit();
    if (dot(before, after) < 0) after = -after;
    const Vec3<double> turned = turned_anchor(anchor, before, after);
    EXPECT_NEAR(dot(turned, after), 0, 1e-14);
    EXPECT_NEAR(length(turned), length(anchor), 1e-14);
    // What is across both normals stays as it is.
    const Vec3<double> axis = cross(before, after);
    EXPECT_NEAR(dot(turned - anchor, axis), 0, 1e-14);
    EXPECT_EQ(turned_anchor(anchor, before, -before), (Vec3<double>{}));
  }
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
