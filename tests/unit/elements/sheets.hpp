#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/unit/elements/configurations.hpp"
#include "weft/elements/membrane_law.hpp"

// Triangles and checks that the tests of all laws of stretching share.

namespace weft::test {

struct RestTriangle {
  Vec3<double> x[3];
  Mat2<double> inv_rest;
  double area;
};

enum class Deformation { random, compressed, sliver, line, near_point, point, folded, count };

/// Centimetre triangles at random in space: moderately deformed; flattened to a fraction of their
/// size; nearly a line; a line; nearly a point; a point; folded flat onto their own plane, that is,
/// mirrored.
inline RestTriangle random_triangle(Random& random, Deformation kind) {
  Vec2<double> rest[3];
  double det = 0;
  do {
    for (auto& r : rest) r = {random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01)};
    const Vec2<double> a = rest[1] - rest[0], b = rest[2] - rest[0];
    det = a[0] * b[1] - a[1] * b[0];
  } while (det < 2e-5);
  const Vec2<double> a = rest[1] - rest[0], b = rest[2] - rest[0];
  RestTriangle s{};
  s.inv_rest = {{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}};
  s.area = det / 2;
  double sx = random.uniform(0.9, 1.3), sy = random.uniform(0.9, 1.3);
  if (kind == Deformation::compressed) sx = random.uniform(0.2, 0.9);
  if (kind == Deformation::sliver) sx = random.uniform(-1e-6, 1e-6);
  if (kind == Deformation::line) sx = 0;
  if (kind == Deformation::near_point) sx = 1e-8, sy = -1e-8;
  if (kind == Deformation::point) sx = sy = 0;
  if (kind == Deformation::folded) sx = -sx;
  const double angle = random.uniform(0, 3), shear = random.uniform(-0.3, 0.3);
  const bool flat = kind == Deformation::folded;
  const Mat3<double> q = flat ? Mat3<double>::identity() : random.rotation();
  const Vec3<double> at = random.point(1);
  for (int i = 0; i < 3; ++i) {
    const double u = std::cos(angle) * rest[i][0] - std::sin(angle) * rest[i][1];
    const double v = std::sin(angle) * rest[i][0] + std::cos(angle) * rest[i][1];
    s.x[i] = q * Vec3<double>{sx * (u + shear * v), sy * v, 0} + at;
  }
  return s;
}

template <class Visit>
void each_triangle(Random& random, const Visit& visit) {
  for (int kind = 0; kind < static_cast<int>(Deformation::count); ++kind)
    for (int i = 0; i < 200; ++i) {
      SCOPED_TRACE(testing::Message() << "kind " << kind << " case " << i);
      visit(random_triangle(random, static_cast<Deformation>(kind)));
    }
}

/// What a block of the Hessian is of the order of, for a stiffness of 1 N/m.
inline double stiffness_scale(const RestTriangle& s) {
  double sum = 0;
  for (const double e : s.inv_rest.e) sum += e * e;
  return s.area * sum;
}

inline Mat2<Long> fine_rest(const RestTriangle& s) {
  Mat2<Long> r{};
  for (int i = 0; i < 4; ++i) r.e[i] = s.inv_rest.e[i];
  return r;
}

/// @param fine  the law in long double
/// @param bound share of the largest stiffness that the difference may have
template <class Law, class Fine>
void expect_gradient(const RestTriangle& s, const Law& law, const Fine& fine, double stiffness,
                     double step = 1e-4, double bound = 1e-10) {
  const auto energy = [&](const Vec3<Long>(&x)[3]) {
    return membrane_law_energy(x, fine_rest(s), static_cast<Long>(s.area), fine);
  };
  Vec3<double> g[3], expected[3];
  membrane_law_gradient(s.x, s.inv_rest, s.area, law, g);
  difference_gradient(energy, s.x, static_cast<Long>(step), expected);
  EXPECT_LE(largest_difference(g, expected), bound * stiffness * stiffness_scale(s));
}

template <class Law, class Fine>
void expect_hessian(const RestTriangle& s, const Law& law, const Fine& fine, double stiffness,
                    double step = 1e-4, double bound = 1e-8) {
  const auto gradient = [&](const Vec3<Long>(&x)[3], Vec3<Long>(&g)[3]) {
    membrane_law_gradient(x, fine_rest(s), static_cast<Long>(s.area), fine, g);
  };
  Mat3<double> h[6], full[3][3], expected[3][3];
  membrane_law_hessian(s.x, s.inv_rest, s.area, law, false, h);
  unfold(h, full);
  difference_hessian(gradient, s.x, static_cast<Long>(step), expected);
  EXPECT_LE(largest_difference(full, expected), bound * stiffness * stiffness_scale(s));
}

using Matrix9 = Eigen::Matrix<double, 9, 9>;

inline Matrix9 matrix_of(const Mat3<double> (&upper)[6]) {
  Mat3<double> full[3][3];
  unfold<3>(upper, full);
  Matrix9 m;
  for (int r = 0; r < 9; ++r)
    for (int c = 0; c < 9; ++c) m(r, c) = full[r / 3][c / 3](r % 3, c % 3);
  return m;
}

inline double least_eigenvalue(const Eigen::MatrixXd& m) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues().minCoeff();
}

/// What to add to a symmetric matrix to make it the nearest semi-definite one.
template <class Matrix>
Matrix missing_to_semidefinite(const Matrix& m) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(m);
  return solver.eigenvectors() * (-solver.eigenvalues()).cwiseMax(0).asDiagonal() *
         solver.eigenvectors().transpose();
}

/// Projected blocks are those of a semi-definite matrix, and differ from the exact ones by what is
/// negative in stress and tangent, S- and D-, and nothing else: area times (b_i . S- b_j) I +
/// B_i^T D- B_j, with b_i the rows of inv_rest and B = dG / dx.
/// @param response the law's, exact
inline void expect_projected(const RestTriangle& s, const Mat3<double> (&exact)[6],
                             const Mat3<double> (&projected)[6],
                             const MembraneResponse<double>& response, double stiffness) {
  const double scale = stiffness * stiffness_scale(s);
  const Matrix9 m = matrix_of(projected);
  EXPECT_EQ((m - m.transpose()).cwiseAbs().maxCoeff(), 0);
  EXPECT_GE(least_eigenvalue(m), -1e-12 * scale);
  const auto strain = detail::membrane_strain(s.x, s.inv_rest);
  const Eigen::Map<const Eigen::Vector3d> f0(strain.f0.e), f1(strain.f1.e);
  Eigen::Matrix<double, 3, 2> b;
  b << 0, 0, s.inv_rest(0, 0), s.inv_rest(0, 1), s.inv_rest(1, 0), s.inv_rest(1, 1);
  b.row(0) = -(b.row(1) + b.row(2));
  Eigen::Matrix<double, 3, 9> rows;
  for (int i = 0; i < 3; ++i) {
    rows.block<1, 3>(0, 3 * i) = b(i, 0) * f0.transpose();
    rows.block<1, 3>(1, 3 * i) = b(i, 1) * f1.transpose();
    rows.block<1, 3>(2, 3 * i) = (b(i, 1) * f0 + b(i, 0) * f1).transpose();
  }
  Eigen::Matrix2d stress;
  stress << response.stress.xx, response.stress.xy, response.stress.xy, response.stress.yy;
  const double* d = response.tangent;
  Eigen::Matrix3d tangent;
  tangent << d[0], d[1], d[2], d[1], d[3], d[4], d[2], d[4], d[5];
  Matrix9 expected = rows.transpose() * missing_to_semidefinite(tangent) * rows;
  const Eigen::Matrix3d geometric = b * missing_to_semidefinite(stress) * b.transpose();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      expected.block<3, 3>(3 * i, 3 * j) += geometric(i, j) * Eigen::Matrix3d::Identity();
  EXPECT_LE((m - matrix_of(exact) - s.area * expected).cwiseAbs().maxCoeff(), 1e-12 * scale);
}

template <class Law>
void expect_projection(const RestTriangle& s, const Law& law, double stiffness) {
  Mat3<double> exact[6], projected[6];
  membrane_law_hessian(s.x, s.inv_rest, s.area, law, false, exact);
  membrane_law_hessian(s.x, s.inv_rest, s.area, law, true, projected);
  const auto green = detail::membrane_strain(s.x, s.inv_rest).green;
  expect_projected(s, exact, projected, law.response(green, false), stiffness);
}

template <class Law>
void expect_fused(const RestTriangle& s, const Law& law) {
  Vec3<double> g[3], g_fused[3];
  Mat3<double> h[6], h_fused[6];
  membrane_law_gradient(s.x, s.inv_rest, s.area, law, g);
  membrane_law_hessian(s.x, s.inv_rest, s.area, law, true, h);
  const auto respond = [&](const detail::Symmetric2<double>& green) {
    return law.response(green, true);
  };
  membrane_law_gradient_hessian(s.x, s.inv_rest, s.area, respond, g_fused, h_fused);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(g[i], g_fused[i]);
  for (int b = 0; b < 6; ++b)
    for (int k = 0; k < 9; ++k) EXPECT_EQ(h[b].e[k], h_fused[b].e[k]);
}

/// Frame invariance, and forces without momentum.
template <class Law>
void expect_invariance(const RestTriangle& s, const Law& law, Random& random, double stiffness) {
  const Mat3<double> q = random.rotation();
  const Vec3<double> shift = random.point(1);
  Vec3<double> moved[3], g[3], g_moved[3], turned[3];
  for (int i = 0; i < 3; ++i) moved[i] = q * s.x[i] + shift;
  const double scale = stiffness * stiffness_scale(s);
  EXPECT_NEAR(membrane_law_energy(s.x, s.inv_rest, s.area, law),
              membrane_law_energy(moved, s.inv_rest, s.area, law), 1e-13 * scale * 0.01);
  membrane_law_gradient(s.x, s.inv_rest, s.area, law, g);
  membrane_law_gradient(moved, s.inv_rest, s.area, law, g_moved);
  Vec3<double> force{}, torque{};
  for (int i = 0; i < 3; ++i) {
    turned[i] = q * g[i];
    force += g[i];
    torque += cross(s.x[i] - s.x[0], g[i]);
  }
  EXPECT_LE(largest_difference(turned, g_moved), 1e-11 * scale * 0.01);
  EXPECT_LE(length(force), 1e-15 * largest(g) * 8);
  EXPECT_LE(length(torque), 1e-13 * scale * 1e-4);
}

}  // namespace weft::test
