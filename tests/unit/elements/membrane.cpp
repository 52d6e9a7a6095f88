#include "weft/elements/membrane.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/unit/elements/sheets.hpp"

namespace weft {
namespace {

using test::Long;
using test::Random;

template <class T>
struct Sheet {
  Vec3<T> x[3];
  Mat2<T> inv_rest;
  T area;
  MembraneConstants<T> c;
};

template <class To, class From>
Sheet<To> cast(const Sheet<From>& s) {
  Sheet<To> r{};
  test::cast(s.x, r.x);
  for (int i = 0; i < 4; ++i) r.inv_rest.e[i] = static_cast<To>(s.inv_rest.e[i]);
  r.area = static_cast<To>(s.area);
  r.c = {static_cast<To>(s.c.lambda), static_cast<To>(s.c.mu)};
  return r;
}

/// A triangle with constants at random.
Sheet<double> random_sheet(Random& random, const test::RestTriangle& triangle) {
  Sheet<double> s{
      {triangle.x[0], triangle.x[1], triangle.x[2]}, triangle.inv_rest, triangle.area, {}};
  s.c = membrane_constants(random.uniform(10, 1000), random.uniform(-0.3, 0.49));
  return s;
}

test::RestTriangle triangle_of(const Sheet<double>& s) {
  return {{s.x[0], s.x[1], s.x[2]}, s.inv_rest, s.area};
}

template <class Visit>
void each_sheet(const Visit& visit) {
  Random random(11);
  test::each_triangle(
      random, [&](const test::RestTriangle& triangle) { visit(random_sheet(random, triangle)); });
}

/// What a block of the Hessian is of the order of, whatever the deformation.
double stiffness_scale(const Sheet<double>& s) {
  return s.c.mu * test::stiffness_scale(triangle_of(s));
}

TEST(Membrane, gradient_is_the_derivative_of_the_energy) {
  each_sheet([](const Sheet<double>& s) {
    const auto fine = cast<Long>(s);
    const auto energy = [&](const Vec3<Long>(&x)[3]) {
      return membrane_energy(x, fine.inv_rest, fine.area, fine.c);
    };
    Vec3<double> g[3], expected[3];
    membrane_gradient(s.x, s.inv_rest, s.area, s.c, g);
    test::difference_gradient(energy, s.x, 1e-4L, expected);
    EXPECT_LE(test::largest_difference(g, expected), 1e-8 * stiffness_scale(s) * 0.01);
  });
}

TEST(Membrane, hessian_is_the_derivative_of_the_gradient) {
  each_sheet([](const Sheet<double>& s) {
    const auto fine = cast<Long>(s);
    const auto gradient = [&](const Vec3<Long>(&x)[3], Vec3<Long>(&g)[3]) {
      membrane_gradient(x, fine.inv_rest, fine.area, fine.c, g);
    };
    Mat3<double> h[6], full[3][3], expected[3][3];
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, false, h);
    test::unfold(h, full);
    test::difference_hessian(gradient, s.x, 1e-4L, expected);
    EXPECT_LE(test::largest_difference(full, expected), 1e-8 * stiffness_scale(s));
  });
}

TEST(Membrane, pull_with_free_sides_costs_half_young_modulus_times_strain_squared) {
  const double stiffness = 100, nu = 0.3, stretch = 1.2;
  const auto c = membrane_constants(stiffness, nu);
  const double strain = (stretch * stretch - 1) / 2;
  const double narrowing = std::sqrt(1 - 2 * nu * strain);  // lateral Green strain -nu strain
  const Mat2<double> inv_rest{{1 / 0.02, 0, 0, 1 / 0.03}};
  const Vec3<double> x[3] = {{1, 2, 3}, {1 + 0.02 * stretch, 2, 3}, {1, 2 + 0.03 * narrowing, 3}};
  const double area = 0.0003;
  EXPECT_NEAR(membrane_energy(x, inv_rest, area, c), area * stiffness / 2 * strain * strain,
              1e-12 * area * stiffness);
  // The sides are free, so the corner on the y axis feels no force across the pull.
  Vec3<double> g[3];
  membrane_gradient(x, inv_rest, area, c, g);
  EXPECT_NEAR(g[2][1], 0, 1e-11);
  // dE/d(stretch) = area stiffness strain stretch, and the corner moves by 0.02 a unit of stretch.
  EXPECT_NEAR(g[1][0], area * stiffness * strain * stretch / 0.02, 1e-11);
}

TEST(Membrane, simple_shear_costs_mu_only_to_first_order) {
  const auto c = membrane_constants(100.0, 0.0);
  EXPECT_EQ(c.lambda, 0);
  EXPECT_EQ(c.mu, 50);
  const double shear = 1e-3;
  const Vec3<double> x[3] = {{0, 0, 0}, {1, 0, 0}, {shear, 1, 0}};
  // G = [0, shear/2; shear/2, shear^2/2]
  EXPECT_NEAR(membrane_energy(x, Mat2<double>::identity(), 0.5, c),
              0.5 * 50 * (shear * shear / 2 + std::pow(shear, 4) / 4), 1e-17);
}

TEST(Membrane, energy_ignores_rotation_and_translation_and_forces_turn_along) {
  Random random(12);
  each_sheet([&](const Sheet<double>& s) {
    const Mat3<double> q = random.rotation();
    const Vec3<double> shift = random.point(1);
    Vec3<double> moved[3], g[3], g_moved[3], turned[3];
    for (int i = 0; i < 3; ++i) moved[i] = q * s.x[i] + shift;
    const double scale = stiffness_scale(s);
    EXPECT_NEAR(membrane_energy(s.x, s.inv_rest, s.area, s.c),
                membrane_energy(moved, s.inv_rest, s.area, s.c), 1e-13 * scale * 0.01);
    membrane_gradient(s.x, s.inv_rest, s.area, s.c, g);
    membrane_gradient(moved, s.inv_rest, s.area, s.c, g_moved);
    for (int i = 0; i < 3; ++i) turned[i] = q * g[i];
    EXPECT_LE(test::largest_difference(turned, g_moved), 1e-11 * scale * 0.01);
  });
}

TEST(Membrane, forces_carry_no_momentum) {
  each_sheet([](const Sheet<double>& s) {
    Vec3<double> g[3];
    membrane_gradient(s.x, s.inv_rest, s.area, s.c, g);
    Vec3<double> force{}, torque{};
    for (int i = 0; i < 3; ++i) {
      force += g[i];
      torque += cross(s.x[i] - s.x[0], g[i]);
    }
    EXPECT_LE(length(force), 1e-15 * test::largest(g) * 8);
    EXPECT_LE(length(torque), 1e-13 * stiffness_scale(s) * 1e-4);
  });
}

TEST(Membrane, projected_hessian_is_semidefinite_and_no_further_off_than_the_compression) {
  bool was_indefinite = false;
  each_sheet([&](const Sheet<double>& s) {
    Mat3<double> projected[6], exact[6];
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, true, projected);
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, false, exact);
    const auto strain = detail::membrane_strain(s.x, s.inv_rest);
    const double straight = 2 * s.c.mu + s.c.lambda;
    test::expect_projected(triangle_of(s), exact, projected,
                           {detail::membrane_stress(strain.green, s.c),
                            {straight, s.c.lambda, 0, straight, 0, s.c.mu}},
                           s.c.mu);
    was_indefinite = was_indefinite ||
                     test::least_eigenvalue(test::matrix_of(exact)) < -0.01 * stiffness_scale(s);
  });
  EXPECT_TRUE(was_indefinite);
}

TEST(Membrane, projection_is_the_nearest_semidefinite_stress) {
  Random random(13);
  for (int i = 0; i < 2000; ++i) {
    detail::Symmetric2<double> s{random.uniform(-1, 1), random.uniform(-1, 1),
                                 random.uniform(-1, 1)};
    if (i % 4 == 1) s.xy *= 1e-9;
    if (i % 4 == 2) s.yy = s.xx + 1e-9 * s.yy;
    Eigen::Matrix2d m;
    m << s.xx, s.xy, s.xy, s.yy;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(m);
    const Eigen::Matrix2d expected = solver.eigenvectors() *
                                     solver.eigenvalues().cwiseMax(0).asDiagonal() *
                                     solver.eigenvectors().transpose();
    const auto p = detail::project_semidefinite(s);
    EXPECT_NEAR(p.xx, expected(0, 0), 1e-14);
    EXPECT_NEAR(p.xy, expected(0, 1), 1e-14);
    EXPECT_NEAR(p.yy, expected(1, 1), 1e-14);
  }
  const auto zero = detail::project_semidefinite(detail::Symmetric2<double>{0, 0, 0});
  EXPECT_EQ(zero.xx, 0);
}

TEST(Membrane, projection_changes_nothing_where_all_is_stretched) {
  Random random(14);
  int stretched = 0;
  for (int i = 0; i < 500; ++i) {
    const Sheet<double> s =
        random_sheet(random, test::random_triangle(random, test::Deformation::random));
    const auto strain = detail::membrane_strain(s.x, s.inv_rest);
    const auto stress = detail::membrane_stress(strain.green, s.c);
    if (!(stress.xx * stress.yy - stress.xy * stress.xy > 0 && stress.xx > 0)) continue;
    ++stretched;
    Mat3<double> projected[6], exact[6];
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, true, projected);
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, false, exact);
    for (int b = 0; b < 6; ++b)
      for (int k = 0; k < 9; ++k) EXPECT_EQ(projected[b].e[k], exact[b].e[k]);
  }
  EXPECT_GT(stretched, 50);
}

TEST(Membrane, fused_form_gives_the_same_bits) {
  each_sheet([](const Sheet<double>& s) {
    Vec3<double> g[3], g_fused[3];
    Mat3<double> h[6], h_fused[6];
    membrane_gradient(s.x, s.inv_rest, s.area, s.c, g);
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, true, h);
    membrane_gradient_hessian(s.x, s.inv_rest, s.area, s.c, g_fused, h_fused);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(g[i], g_fused[i]);
    for (int b = 0; b < 6; ++b)
      for (int k = 0; k < 9; ++k) EXPECT_EQ(h[b].e[k], h_fused[b].e[k]);
  });
}

TEST(Membrane, float_follows_double) {
  each_sheet([](Sheet<double> s) {
    const auto f = cast<float>(s);
    test::cast(f.x, s.x);  // the same corners, so that only the arithmetic differs
    Vec3<double> g[3], g_of_float[3];
    Vec3<float> gf[3];
    Mat3<double> h[6];
    Mat3<float> hf[6];
    membrane_gradient_hessian(s.x, s.inv_rest, s.area, s.c, g, h);
    membrane_gradient_hessian(f.x, f.inv_rest, f.area, f.c, gf, hf);
    test::cast(gf, g_of_float);
    const double scale = stiffness_scale(s);
    EXPECT_LE(test::largest_difference(g, g_of_float), 1e-6 * scale * 0.02);
    // Of the order of the largest constant, 2 mu + lambda.
    const double straight = 2 + std::fmax(s.c.lambda, 0) / s.c.mu;
    for (int b = 0; b < 6; ++b)
      for (int k = 0; k < 9; ++k)
        EXPECT_NEAR(h[b].e[k], static_cast<double>(hf[b].e[k]), 2e-6 * straight * scale);
    EXPECT_NEAR(membrane_energy(s.x, s.inv_rest, s.area, s.c),
                static_cast<double>(membrane_energy(f.x, f.inv_rest, f.area, f.c)),
                4e-6 * s.area * s.c.mu);
  });
}

}  // namespace
}  // namespace weft
