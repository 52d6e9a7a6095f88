#include "weft/elements/membrane.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/unit/elements/configurations.hpp"

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

Sheet<double> rest_sheet(Random& random, const Vec2<double> rest[3]) {
  const Vec2<double> a = rest[1] - rest[0], b = rest[2] - rest[0];
  const double det = a[0] * b[1] - a[1] * b[0];
  Sheet<double> s{};
  s.inv_rest = {{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}};
  s.area = det / 2;
  s.c = membrane_constants(random.uniform(10, 1000), random.uniform(-0.3, 0.49));
  return s;
}

enum class Kind { random, compressed, sliver, point, count };

/// Centimetre triangles at random in space: moderately deformed; flattened to a fraction of their
/// size; nearly a line; nearly a point.
Sheet<double> random_sheet(Random& random, Kind kind) {
  Vec2<double> rest[3];
  double det = 0;
  do {
    for (auto& r : rest) r = {random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01)};
    const Vec2<double> a = rest[1] - rest[0], b = rest[2] - rest[0];
    det = a[0] * b[1] - a[1] * b[0];
  } while (det < 2e-5);
  Sheet<double> s = rest_sheet(random, rest);
  double sx = random.uniform(0.9, 1.3), sy = random.uniform(0.9, 1.3);
  if (kind == Kind::compressed) sx = random.uniform(0.2, 0.9);
  if (kind == Kind::sliver) sx = random.uniform(-1e-6, 1e-6);
  if (kind == Kind::point) sx = 1e-8, sy = -1e-8;
  const double angle = random.uniform(0, 3), shear = random.uniform(-0.3, 0.3);
  const Mat3<double> q = random.rotation();
  const Vec3<double> at = random.point(1);
  for (int i = 0; i < 3; ++i) {
    const double u = std::cos(angle) * rest[i][0] - std::sin(angle) * rest[i][1];
    const double v = std::sin(angle) * rest[i][0] + std::cos(angle) * rest[i][1];
    s.x[i] = q * Vec3<double>{sx * (u + shear * v), sy * v, 0} + at;
  }
  return s;
}

template <class Visit>
void each_sheet(const Visit& visit) {
  Random random(11);
  for (int kind = 0; kind < static_cast<int>(Kind::count); ++kind)
    for (int i = 0; i < 500; ++i) {
      SCOPED_TRACE(testing::Message() << "kind " << kind << " case " << i);
      visit(random_sheet(random, static_cast<Kind>(kind)));
    }
}

/// What a block of the Hessian is of the order of, whatever the deformation.
double stiffness_scale(const Sheet<double>& s) {
  return s.area * s.c.mu *
         (length_sq(
             Vec<double, 4>{s.inv_rest.e[0], s.inv_rest.e[1], s.inv_rest.e[2], s.inv_rest.e[3]}));
}

Eigen::Matrix<double, 9, 9> assemble(const Mat3<double> (&upper)[6]) {
  Mat3<double> full[3][3];
  test::unfold<3>(upper, full);
  Eigen::Matrix<double, 9, 9> m;
  for (int r = 0; r < 9; ++r)
    for (int c = 0; c < 9; ++c) m(r, c) = full[r / 3][c / 3](r % 3, c % 3);
  return m;
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

TEST(Membrane, projected_hessian_is_semidefinite) {
  bool was_indefinite = false;
  each_sheet([&](const Sheet<double>& s) {
    Mat3<double> h[6], exact[6];
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, true, h);
    membrane_hessian(s.x, s.inv_rest, s.area, s.c, false, exact);
    const Eigen::Matrix<double, 9, 9> m = assemble(h), e = assemble(exact);
    EXPECT_EQ((m - m.transpose()).cwiseAbs().maxCoeff(), 0);
    const double least = Eigen::SelfAdjointEigenSolver<decltype(e)>(m).eigenvalues().minCoeff();
    EXPECT_GE(least, -1e-12 * stiffness_scale(s));
    const double before = Eigen::SelfAdjointEigenSolver<decltype(e)>(e).eigenvalues().minCoeff();
    was_indefinite = was_indefinite || before < -0.01 * stiffness_scale(s);
    // Removing negative stress can only add stiffness.
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<decltype(e)>(m - e).eigenvalues().minCoeff(),
              -1e-12 * stiffness_scale(s));
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
    const Sheet<double> s = random_sheet(random, Kind::random);
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
    for (int b = 0; b < 6; ++b)
      for (int k = 0; k < 9; ++k)
        EXPECT_NEAR(h[b].e[k], static_cast<double>(hf[b].e[k]), 4e-6 * scale);
    EXPECT_NEAR(membrane_energy(s.x, s.inv_rest, s.area, s.c),
                static_cast<double>(membrane_energy(f.x, f.inv_rest, f.area, f.c)),
                4e-6 * s.area * s.c.mu);
  });
}

}  // namespace
}  // namespace weft
