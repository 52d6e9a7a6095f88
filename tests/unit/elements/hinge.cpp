#include "weft/elements/hinge.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "tests/unit/elements/configurations.hpp"
#include "tests/unit/elements/hinge_hessian.hpp"

namespace weft {
namespace {

using std::numbers::pi;
using test::Long;
using test::Random;

struct Fold {
  Vec3<double> x[4];
  double theta;   ///< angle that it was made with
  double height;  ///< the lesser height over the edge
};

/// A hinge along the x axis, folded by theta, then moved at random.
Fold make_fold(Random& random, double theta, double height2, double height3, bool move = true) {
  Fold f{};
  const double edge = random.uniform(0.5, 1.5);
  f.x[1] = {edge, 0, 0};
  f.x[2] = {random.uniform(-0.5, 1.5), height2, 0};
  f.x[3] = {random.uniform(-0.5, 1.5), -height3 * std::cos(theta), -height3 * std::sin(theta)};
  f.theta = theta;
  f.height = std::fmin(height2, height3);
  if (move) {
    const Mat3<double> q = random.rotation();
    const Vec3<double> shift = random.point(1);
    for (auto& p : f.x) p = q * p + shift;
  }
  return f;
}

enum class Kind { random, flat, level, folded, sliver, slivers, count };

Fold random_fold(Random& random, Kind kind) {
  const double sign = random.uniform(-1, 1) < 0 ? -1 : 1;
  const double h2 = random.uniform(0.3, 1.2), h3 = random.uniform(0.3, 1.2);
  switch (kind) {
    case Kind::flat:
      return make_fold(random, sign * random.decade(-9, -3), h2, h3);
    case Kind::level:
      return make_fold(random, 0, h2, h3, random.below(2) == 0);
    case Kind::folded:
      return make_fold(random, sign * (pi - random.decade(-3, -1)), h2, h3);
    case Kind::sliver:
      return make_fold(random, random.uniform(-3, 3), h2, random.decade(-4, -2));
    case Kind::slivers:
      return make_fold(random, random.uniform(-3, 3), random.decade(-4, -2), random.decade(-4, -2));
    default:
      return make_fold(random, random.uniform(-3, 3), h2, h3);
  }
}

template <class Visit>
void each_fold(const Visit& visit) {
  Random random(21);
  for (int kind = 0; kind < static_cast<int>(Kind::count); ++kind)
    for (int i = 0; i < 500; ++i) {
      SCOPED_TRACE(testing::Message() << "kind " << kind << " case " << i);
      visit(random_fold(random, static_cast<Kind>(kind)));
    }
}

/// Rounding of the corners (about 1) as the angle feels it.
double angle_error(const Fold& f) {
  return 1e-15 / f.height * 8;
}

TEST(Hinge, angle_is_the_one_that_the_fold_was_made_with) {
  each_fold([](const Fold& f) { EXPECT_NEAR(hinge_angle(f.x), f.theta, angle_error(f)); });
}

TEST(Hinge, ridge_is_positive_and_valley_negative) {
  const Vec3<double> ridge[4] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0, -1}};
  const Vec3<double> valley[4] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0, 1}};
  EXPECT_NEAR(hinge_angle(ridge), pi / 2, 1e-15);
  EXPECT_NEAR(hinge_angle(valley), -pi / 2, 1e-15);
}

TEST(Hinge, fold_onto_itself_is_pi_from_either_side) {
  for (const double zero : {0.0, -0.0}) {
    const Vec3<double> x[4] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, zero}, {0.5, 1, -zero}};
    EXPECT_EQ(hinge_angle(x), pi);
    Vec3<double> t[4];
    EXPECT_EQ(hinge_angle_gradient(x, t), pi);
    EXPECT_EQ(t[2], (Vec3<double>{0, 0, -1}));
    EXPECT_EQ(t[3], (Vec3<double>{0, 0, 1}));
  }
}

TEST(Hinge, angle_gradient_is_the_derivative_of_the_angle) {
  each_fold([](const Fold& f) {
    const auto angle = [](const Vec3<Long>(&x)[4]) { return hinge_angle(x); };
    Vec3<double> t[4], expected[4];
    EXPECT_EQ(hinge_angle_gradient(f.x, t), hinge_angle(f.x));
    test::difference_gradient(angle, f.x, 1e-4L * static_cast<Long>(f.height), expected);
    EXPECT_LE(test::largest_difference(t, expected), 1e-10 / f.height);
  });
}

TEST(Hinge, angle_hessian_is_the_derivative_of_the_angle_gradient) {
  each_fold([](const Fold& f) {
    const auto gradient = [](const Vec3<Long>(&x)[4], Vec3<Long>(&t)[4]) {
      hinge_angle_gradient(x, t);
    };
    Mat3<double> h[10], full[4][4], expected[4][4];
    hinge_angle_hessian(f.x, h);
    test::unfold(h, full);
    test::difference_hessian(gradient, f.x, 1e-4L * static_cast<Long>(f.height), expected);
    EXPECT_LE(test::largest_difference(full, expected), 1e-9 / (f.height * f.height));
  });
}

TEST(Hinge, gradient_is_the_derivative_of_the_energy) {
  each_fold([](const Fold& f) {
    const double rest = 0.3, c = 2;
    const auto energy = [](const Vec3<Long>(&x)[4]) { return hinge_energy(x, 0.3L, 2.0L); };
    Vec3<double> g[4], expected[4];
    hinge_gradient(f.x, rest, c, g);
    test::difference_gradient(energy, f.x, 1e-4L * static_cast<Long>(f.height), expected);
    EXPECT_LE(test::largest_difference(g, expected), 1e-9 / f.height);
  });
}

TEST(Hinge, hessian_is_the_derivative_of_the_gradient) {
  each_fold([](const Fold& f) {
    const double rest = 0.3, c = 2;
    const auto gradient = [](const Vec3<Long>(&x)[4], Vec3<Long>(&g)[4]) {
      hinge_gradient(x, 0.3L, 2.0L, g);
    };
    Mat3<double> h[10], full[4][4], expected[4][4];
    hinge_hessian(f.x, rest, c, h);
    test::unfold(h, full);
    test::difference_hessian(gradient, f.x, 1e-4L * static_cast<Long>(f.height), expected);
    EXPECT_LE(test::largest_difference(full, expected), 1e-8 / (f.height * f.height));
  });
}

TEST(Hinge, fused_form_is_gradient_and_gauss_newton_part) {
  each_fold([](const Fold& f) {
    const double c = 2;
    for (const double rest : {0.3, hinge_angle(f.x)}) {
      Vec3<double> g[4], g_fused[4], t[4], t_fused[4];
      hinge_gradient(f.x, rest, c, g);
      hinge_angle_gradient(f.x, t);
      EXPECT_EQ(hinge_gradient_hessian(f.x, rest, c, g_fused, t_fused), 2 * c);
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(g[i], g_fused[i]);
        EXPECT_EQ(t[i], t_fused[i]);
      }
    }
    // At rest nothing is left out.
    Mat3<double> exact[10];
    Vec3<double> t[4], g[4];
    const double rest = hinge_angle(f.x);
    hinge_hessian(f.x, rest, c, exact);
    const double weight = hinge_gradient_hessian(f.x, rest, c, g, t);
    int block = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j, ++block)
        for (int k = 0; k < 9; ++k)
          EXPECT_NEAR(exact[block].e[k], weight * outer(t[i], t[j]).e[k],
                      1e-14 / (f.height * f.height));
  });
}

Eigen::Matrix<double, 12, 12> matrix_of(const Mat3<double> (&upper)[10]) {
  Mat3<double> full[4][4];
  test::unfold<4>(upper, full);
  Eigen::Matrix<double, 12, 12> m;
  for (int r = 0; r < 12; ++r)
    for (int c = 0; c < 12; ++c) m(r, c) = full[r / 3][c / 3](r % 3, c % 3);
  return m;
}

TEST(Hinge, gauss_newton_part_is_semidefinite_and_off_as_much_as_the_hinge_is_from_rest) {
  each_fold([](const Fold& f) {
    const double c = 2, theta = hinge_angle(f.x);
    Eigen::Matrix<double, 12, 12> first;
    for (const double off : {0.1, 1e-3, 1e-6}) {
      Mat3<double> exact[10], part[10];
      Vec3<double> g[4], t[4];
      hinge_hessian(f.x, theta - off, c, exact);
      const double weight = hinge_gradient_hessian(f.x, theta - off, c, g, t);
      int block = 0;
      for (int i = 0; i < 4; ++i)
        for (int j = i; j < 4; ++j, ++block) part[block] = weight * outer(t[i], t[j]);
      const auto m = matrix_of(part);
      const double size = m.cwiseAbs().maxCoeff();
      EXPECT_EQ((m - m.transpose()).cwiseAbs().maxCoeff(), 0);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(m);
      EXPECT_GE(solver.eigenvalues()[0], -1e-14 * size);
      EXPECT_LE(solver.eigenvalues()[10], 1e-14 * size) << "of rank one";
      const Eigen::Matrix<double, 12, 12> rate = (matrix_of(exact) - m) / off;
      if (off == 0.1) first = rate;
      EXPECT_LE((rate - first).cwiseAbs().maxCoeff(),
                1e-8 * first.cwiseAbs().maxCoeff() + 1e-14 * size / off);
    }
  });
}

/// Folded shut, normals against each other: the angle is at pi, and a little further it is at -pi.
/// Its derivatives are those of the angle that goes on past pi.
TEST(Hinge, derivatives_where_it_is_folded_shut) {
  Random random(24);
  for (int i = 0; i < 200; ++i) {
    Fold f = make_fold(random, pi, random.uniform(0.3, 1.2), random.uniform(0.3, 1.2), i % 2 == 0);
    if (i % 4 == 1) f.x[3] = f.x[2];  // the triangles are one
    const double theta = hinge_angle(f.x), rest = 0.3, c = 2;
    EXPECT_NEAR(std::fabs(theta), pi, 1e-14);
    const auto ahead = [&](const Vec3<Long>(&x)[4]) {
      const Long centre = theta;
      return centre + std::remainder(hinge_angle(x) - centre, 2 * std::numbers::pi_v<Long>);
    };
    const auto energy = [&](const Vec3<Long>(&x)[4]) {
      const Long bend = ahead(x) - static_cast<Long>(rest);
      return static_cast<Long>(c) * bend * bend;
    };
    const auto gradient = [&](const Vec3<Long>(&x)[4], Vec3<Long>(&g)[4]) {
      hinge_angle_gradient(x, g);
      const Long slope = 2 * static_cast<Long>(c) * (ahead(x) - static_cast<Long>(rest));
      for (auto& v : g) v *= slope;
    };
    Vec3<double> g[4], expected[4];
    hinge_gradient(f.x, rest, c, g);
    test::difference_gradient(energy, f.x, 1e-5L, expected);
    EXPECT_LE(test::largest_difference(g, expected), 1e-9 / f.height);
    Mat3<double> h[10], full[4][4], expected_h[4][4];
    hinge_hessian(f.x, rest, c, h);
    test::unfold(h, full);
    test::difference_hessian(gradient, f.x, 1e-5L, expected_h);
    EXPECT_LE(test::largest_difference(full, expected_h), 1e-8 / (f.height * f.height));
  }
}

TEST(Hinge, energy_of_a_bent_cylinder_is_half_stiffness_times_curvature_squared) {
  // A grid of nx x ny cells a x b, each cut along a diagonal, bent about y to radius 1/kappa.
  const int nx = 7, ny = 4;
  const double a = 0.013, b = 0.02, kappa = 9, bending = 3e-5;
  const auto at = [&](int i, int j) {
    const double s = i * a * kappa;
    return Vec3<double>{std::sin(s) / kappa, j * b, std::cos(s) / kappa};
  };
  const double c_across = hinge_coefficient(bending, b, a * b);
  const double c_along = hinge_coefficient(bending, a, a * b);
  const double c_diagonal = hinge_coefficient(bending, std::hypot(a, b), a * b);
  double energy = 0;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const Vec3<double> diagonal[4] = {at(i, j), at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)};
      energy += hinge_energy(diagonal, 0.0, c_diagonal);
      if (i > 0) {
        const Vec3<double> across[4] = {at(i, j), at(i, j + 1), at(i - 1, j), at(i + 1, j + 1)};
        EXPECT_NEAR(hinge_angle(across), kappa * a, 1e-13);
        energy += hinge_energy(across, 0.0, c_across);
      }
      if (j > 0) {
        const Vec3<double> along[4] = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j - 1)};
        energy += hinge_energy(along, 0.0, c_along);
      }
    }
  // The outermost half cells have no hinge at their ends.
  const double area = (nx - 1) * a * ny * b;
  EXPECT_NEAR(energy, bending / 2 * kappa * kappa * area, 1e-12 * bending * kappa * kappa * area);
}

TEST(Hinge, energy_ignores_rotation_and_translation_and_forces_turn_along) {
  Random random(22);
  each_fold([&](const Fold& f) {
    const Mat3<double> q = random.rotation();
    const Vec3<double> shift = random.point(1);
    Vec3<double> moved[4], g[4], turned[4], g_moved[4];
    for (int i = 0; i < 4; ++i) moved[i] = q * f.x[i] + shift;
    EXPECT_NEAR(hinge_energy(f.x, 0.3, 2.0), hinge_energy(moved, 0.3, 2.0), 30 * angle_error(f));
    hinge_gradient(f.x, 0.3, 2.0, g);
    hinge_gradient(moved, 0.3, 2.0, g_moved);
    for (int i = 0; i < 4; ++i) turned[i] = q * g[i];
    EXPECT_LE(test::largest_difference(turned, g_moved), 60 * angle_error(f) / f.height);
  });
}

TEST(Hinge, forces_carry_no_momentum) {
  each_fold([](const Fold& f) {
    Vec3<double> g[4];
    hinge_gradient(f.x, 0.3, 2.0, g);
    Vec3<double> force{}, torque{};
    for (int i = 0; i < 4; ++i) {
      force += g[i];
      torque += cross(f.x[i] - f.x[0], g[i]);
    }
    EXPECT_LE(length(force), 4e-15 * test::largest(g));
    EXPECT_LE(length(torque), 4e-14 * test::largest(g));
  });
}

template <class T>
void expect_zeros(const Vec3<T> (&x)[4]) {
  Vec3<T> g[4], t[4];
  Mat3<T> h[10];
  EXPECT_EQ(hinge_angle(x), T(0));
  EXPECT_EQ(hinge_energy(x, T(0.3), T(2)), T(0));
  hinge_gradient_hessian(x, T(0.3), T(2), g, t);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(g[i], Vec3<T>{});
    EXPECT_EQ(t[i], Vec3<T>{});
  }
  hinge_hessian(x, T(0.3), T(2), h);
  for (const auto& block : h)
    for (const T e : block.e) EXPECT_EQ(e, T(0));
}

template <class T>
void test_degenerate() {
  const Vec3<T> a{T(0.1), T(0.2), T(0.3)}, b{T(1.1), T(0.7), T(0.4)}, c{T(0.5), T(1.3), T(0.2)};
  expect_zeros<T>({a, a, a, a});                     // a point
  expect_zeros<T>({a, a, b, c});                     // edge of no length
  expect_zeros<T>({a, b, (a + b) * T(0.5), c});      // first triangle a line
  expect_zeros<T>({a, b, c, a + (b - a) * T(1.7)});  // second triangle a line
  expect_zeros<T>({a, b, a, c});
  expect_zeros<T>({a, b, c, b});
  Random random(23);
  for (int i = 0; i < 20000; ++i) {
    // Down to the size where squares underflow, with heights from nothing to large.
    const double size = random.decade(sizeof(T) == 4 ? -22 : -160, 3);
    const Vec3<T> edge = random.unit<T>();
    Vec3<T> x[4];
    x[0] = random.point<T>(1);
    x[1] = x[0] + edge;
    for (int k = 2; k < 4; ++k)
      x[k] = x[0] + edge * T(random.uniform(-1, 2)) +
             random.unit<T>() * T(random.decade(sizeof(T) == 4 ? -9 : -18, 0));
    for (auto& p : x) p *= T(size);
    Vec3<T> g[4], t[4];
    hinge_gradient_hessian(x, T(0.3), T(1e-5), g, t);
    for (int k = 0; k < 4; ++k)
      for (int e = 0; e < 3; ++e) {
        EXPECT_TRUE(std::isfinite(g[k][e]));
        EXPECT_TRUE(std::isfinite(t[k][e]));
      }
    EXPECT_TRUE(std::isfinite(hinge_energy(x, T(0.3), T(1e-5))));
  }
}

TEST(Hinge, triangles_without_area_give_zeros_in_double) {
  test_degenerate<double>();
}
TEST(Hinge, triangles_without_area_give_zeros_in_float) {
  test_degenerate<float>();
}

TEST(Hinge, float_follows_double) {
  each_fold([](const Fold& f) {
    Vec3<float> xf[4], gf[4], tf[4];
    Vec3<double> x[4], g[4], t[4], tf_as_double[4];
    test::cast(f.x, xf);
    test::cast(xf, x);
    hinge_gradient_hessian(xf, 0.3f, 2.0f, gf, tf);
    hinge_gradient_hessian(x, 0.3, 2.0, g, t);
    test::cast(tf, tf_as_double);
    EXPECT_LE(test::largest_difference(t, tf_as_double), 1e-5 / f.height * (1 + 0.1 / f.height));
    const double difference = hinge_angle(x) - static_cast<double>(hinge_angle(xf));
    EXPECT_LE(std::fabs(std::remainder(difference, 2 * pi)), 2e-6 / f.height);
  });
}

}  // namespace
}  // namespace weft
