#include "host/scene/fabric/measured.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/model/material_rows.hpp"
#include "tests/unit/elements/sheets.hpp"

namespace weft {
namespace {

using test::Long;
using test::Random;
using test::RestTriangle;
using Strain = detail::Symmetric2<double>;

/// Tables such as measurements give: no symmetry, some numbers negative.
MeasuredStretch random_tables(Random& random) {
  MeasuredStretch m;
  for (auto& row : m.rows) {
    const double weft = random.uniform(50, 400);
    row = {random.uniform(20, 250), random.uniform(-20, 200), weft, random.uniform(-30, 90)};
  }
  return m;
}

/// Tables of a sheet whose stiffness does not depend on strain.
MeasuredStretch constant_tables(const std::array<double, 4>& row) {
  MeasuredStretch m;
  m.rows.fill(row);
  return m;
}

Strain random_strain(Random& random, double least, double most) {
  const double a = random.uniform(least, most), b = random.uniform(least, most);
  const double angle = random.uniform(0, std::numbers::pi);
  const double c = std::cos(angle), s = std::sin(angle);
  const double ga = (a * a - 1) / 2, gb = (b * b - 1) / 2;
  return {ga * c * c + gb * s * s, (ga - gb) * c * s, ga * s * s + gb * c * c};
}

double hat(double x) {
  return std::max(0.0, 1 - std::abs(x));
}

/// The definition of a sample once more, by other means.
Eigen::Vector4d defined_sample(const MeasuredStretch& m, double g00, double g11, double g01) {
  Eigen::Matrix2d stretch_sq;
  stretch_sq << 2 * g00 + 1, 2 * g01, 2 * g01, 2 * g11 + 1;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(stretch_sq);
  const Eigen::Vector2d direction = solver.eigenvectors().col(1);
  const bool round = g00 == g11 && g01 == 0;
  const double degrees =
      round ? 0 : std::acos(std::min(1.0, std::abs(direction[0]))) * 180 / std::numbers::pi;
  const double share = std::clamp((std::sqrt(solver.eigenvalues()[1]) - 1) / (1 / 6.0), 0.0, 1.0);
  Eigen::Vector4d result = Eigen::Vector4d::Zero();
  for (std::size_t row = 0; row < 6; ++row) {
    const double weight =
        row == 0 ? 1 - share
                 : share * hat((degrees - 22.5 * (static_cast<double>(row) - 1)) / 22.5);
    result += weight * Eigen::Map<const Eigen::Vector4d>(m.rows[row].data());
  }
  return 2 * result.cwiseMax(0);
}

Eigen::Vector4d defined(const MeasuredStretch& m, const Strain& g) {
  const double last = 29 / 30.0;
  const double at[3] = {std::clamp(g.xx, -0.25, -0.25 + last),
                        std::clamp(g.yy, -0.25, -0.25 + last),
                        std::clamp(std::abs(g.xy), 0.0, last)};
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j)
      for (int k = 0; k < 30; ++k) {
        const double x = -0.25 + i / 30.0, y = -0.25 + j / 30.0, z = k / 30.0;
        const double weight = hat((at[0] - x) * 30) * hat((at[1] - y) * 30) * hat((at[2] - z) * 30);
        if (weight > 0) sum += weight * defined_sample(m, x, y, z);
      }
  return sum;
}

TEST(MeasuredSamples, are_the_definition) {
  Random random(31);
  bool was_indefinite = false;
  for (int table = 0; table < 3; ++table) {
    const MeasuredStretch m = random_tables(random);
    const std::vector<double> samples = sample_measured(m);
    ASSERT_EQ(samples.size(), 108000u);
    const MembraneSamples<double> law{samples.data()};
    for (int i = 0; i < 60; ++i) {
      Strain g = random_strain(random, 0.6, 1.7);
      if (i % 10 == 0) g = {g.xx, 0, g.xx};
      if (i % 10 == 1) g = {random.uniform(1, 3), random.uniform(-3, -1), -0.4};
      const Eigen::Vector4d expected = defined(m, g);
      const OrthotropicMembrane<double> c = law.coefficients(g);
      EXPECT_NEAR(c.c11, expected[0], 1e-9);
      EXPECT_NEAR(c.c12, expected[1], 1e-9);
      EXPECT_NEAR(c.c22, expected[2], 1e-9);
      EXPECT_NEAR(c.c33, expected[3], 1e-9);
      const auto s = law.response(g, false).stress;
      EXPECT_NEAR(s.xx, expected[0] * g.xx + expected[1] * g.yy, 1e-8);
      EXPECT_NEAR(s.yy, expected[1] * g.xx + expected[2] * g.yy, 1e-8);
      EXPECT_NEAR(s.xy, expected[3] * g.xy, 1e-8);
      const auto projected = law.response(g, true);
      EXPECT_EQ(s.xx, projected.stress.xx);
      EXPECT_EQ(s.xy, projected.stress.xy);
      EXPECT_EQ(s.yy, projected.stress.yy);
      Eigen::Matrix2d threads;
      threads << expected[0], expected[1], expected[1], expected[2];
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(threads);
      was_indefinite = was_indefinite || solver.eigenvalues()[0] < -1;
      threads = solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() *
                solver.eigenvectors().transpose();
      EXPECT_NEAR(projected.tangent[0], threads(0, 0), 1e-9);
      EXPECT_NEAR(projected.tangent[1], threads(0, 1), 1e-9);
      EXPECT_NEAR(projected.tangent[3], threads(1, 1), 1e-9);
      EXPECT_NEAR(projected.tangent[5], expected[3] / 2, 1e-9);
    }
  }
  EXPECT_TRUE(was_indefinite);
}

TEST(MeasuredSamples, rows_by_hand) {
  MeasuredStretch m;
  m.rows[0] = {1, 2, 3, 4};
  for (std::size_t i = 1; i < 6; ++i) m.rows[i] = {10.0 * static_cast<double>(i), -5, 7, 0};
  const auto at = [&](int i, int j, int k) {
    const std::vector<double> all = sample_measured(m);
    const double* c = all.data() + 4 * ((i * 30 + j) * 30 + k);
    return std::array<double, 4>{c[0], c[1], c[2], c[3]};
  };
  // compressed in all directions: the first row, doubled
  EXPECT_EQ(at(0, 0, 0), (std::array<double, 4>{2, 4, 6, 8}));
  // far along the warp: the second row, doubled, without what is negative
  EXPECT_EQ(at(29, 0, 0), (std::array<double, 4>{20, 0, 14, 0}));
  // far along the weft: the last row
  EXPECT_NEAR(at(0, 29, 0)[0], 100, 1e-12);
  // far along the diagonal: 45 degrees
  EXPECT_NEAR(at(20, 20, 20)[0], 60, 1e-12);
}

TEST(MeasuredSamples, jacobian_is_that_of_frozen_coefficients) {
  Random random(32);
  const MeasuredStretch m = random_tables(random);
  const std::vector<double> samples = sample_measured(m);
  const MembraneSamples<double> law{samples.data()};
  test::each_triangle(random, [&](const RestTriangle& s) {
    const auto strain = detail::membrane_strain(s.x, s.inv_rest).green;
    const OrthotropicMembrane<double> frozen = law.coefficients(strain);
    const OrthotropicMembrane<Long> fine{frozen.c11, frozen.c12, frozen.c22, frozen.c33};
    // the forces are those of the frozen law, and so is the Jacobian
    Vec3<double> g[3], g_frozen[3];
    membrane_law_gradient(s.x, s.inv_rest, s.area, law, g);
    membrane_law_gradient(s.x, s.inv_rest, s.area, frozen, g_frozen);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(g[i], g_frozen[i]);
    test::expect_gradient(s, frozen, fine, 1000);
    test::expect_hessian(s, frozen, fine, 1000);
    Mat3<double> h[6], h_frozen[6];
    membrane_law_hessian(s.x, s.inv_rest, s.area, law, false, h);
    membrane_law_hessian(s.x, s.inv_rest, s.area, frozen, false, h_frozen);
    for (int b = 0; b < 6; ++b)
      for (int k = 0; k < 9; ++k) EXPECT_EQ(h[b].e[k], h_frozen[b].e[k]);
    test::expect_projection(s, law, 1000);
    test::expect_fused(s, law);
    test::expect_invariance(s, law, random, 1000);
  });
}

TEST(MeasuredFit, derivatives) {
  Random random(33);
  const MeasuredFit fit = fit_measured(random_tables(random));
  const std::vector<Long> values(fit.values.begin(), fit.values.end());
  const MembraneRidges<double> law{fit.values.data()};
  const MembraneRidges<Long> fine{values.data()};
  // The third derivative jumps at knots: short steps, so that its part stays below the bound.
  constexpr double step = 1e-9, bound = 1e-5;
  test::each_triangle(random, [&](const RestTriangle& s) {
    test::expect_gradient(s, law, fine, 1000, step, 1e-8);
    test::expect_hessian(s, law, fine, 1000, step, bound);
    test::expect_projection(s, law, 1000);
    test::expect_fused(s, law);
    test::expect_invariance(s, law, random, 1000);
  });
}

TEST(MeasuredFit, rests_unstretched_and_is_convex) {
  Random random(34);
  const MeasuredFit fit = fit_measured(random_tables(random));
  const MembraneRidges<double> law{fit.values.data()};
  const Strain rest{0, 0, 0};
  EXPECT_NEAR(law.energy(rest), 0, 1e-15);
  const auto r = law.response(rest, false);
  EXPECT_NEAR(r.stress.xx, 0, 1e-13);
  EXPECT_NEAR(r.stress.xy, 0, 1e-13);
  EXPECT_NEAR(r.stress.yy, 0, 1e-13);
  for (int i = 0; i < 500; ++i) {
    const Strain a = random_strain(random, 0.3, 2), b = random_strain(random, 0.3, 2);
    const Strain middle{(a.xx + b.xx) / 2, (a.xy + b.xy) / 2, (a.yy + b.yy) / 2};
    EXPECT_LE(law.energy(middle), (law.energy(a) + law.energy(b)) / 2 * (1 + 1e-12));
    // the mirror image by either thread costs the same
    EXPECT_NEAR(law.energy(a), law.energy({a.xx, -a.xy, a.yy}), 1e-12 * law.energy(a));
  }
}

/// Error of a fit over strains that it was not made from, in the measure of MeasuredFit::error.
double error_elsewhere(const MeasuredStretch& tables, const MeasuredFit& fit, Random& random) {
  const std::vector<double> samples = sample_measured(tables);
  const MembraneSamples<double> exact{samples.data()};
  const MembraneRidges<double> law{fit.values.data()};
  double error = 0, total = 0;
  for (int i = 0; i < 4000; ++i) {
    const Strain g = random_strain(random, 0.85, 1.35);
    const double size_sq = g.xx * g.xx + 2 * g.xy * g.xy + g.yy * g.yy;
    if (size_sq < 1e-6) continue;
    const auto s = law.response(g, false).stress, t = exact.response(g, false).stress;
    const double x = s.xx - t.xx, y = s.yy - t.yy, z = s.xy - t.xy;
    error += (x * x + y * y + 2 * z * z) / size_sq;
    total += (t.xx * t.xx + t.yy * t.yy + 2 * t.xy * t.xy) / size_sq;
  }
  return std::sqrt(error / total);
}

TEST(MeasuredFit, of_a_linear_sheet_is_that_sheet) {
  const MeasuredStretch tables = constant_tables({400, 60, 300, 90});
  const MeasuredFit fit = fit_measured(tables);
  EXPECT_LT(fit.error, 1e-3);
  Random random(35);
  EXPECT_LT(error_elsewhere(tables, fit, random), 1e-3);
}

TEST(MeasuredFit, error_is_what_it_says) {
  Random random(36);
  for (int i = 0; i < 4; ++i) {
    const MeasuredStretch tables = random_tables(random);
    const MeasuredFit fit = fit_measured(tables);
    EXPECT_NEAR(error_elsewhere(tables, fit, random), fit.error, 0.15 * fit.error);
  }
}

TEST(Measured, rows_and_tables_of_materials) {
  Material plain, as_arcsim, fitted;
  Random random(37);
  as_arcsim.measured = random_tables(random);
  as_arcsim.measured->form = MeasuredStretch::Form::arcsim;
  fitted.measured = random_tables(random);
  const std::vector<Material> materials{plain, as_arcsim, fitted};
  std::vector<std::vector<double>> tables;
  for (const Material& m : materials) tables.push_back(stretch_table(m));
  const MaterialRows<double> all = material_rows<double>(materials, tables);
  EXPECT_EQ(all.rows[0].kind, MembraneKind::isotropic);
  EXPECT_EQ(all.rows[1].kind, MembraneKind::samples);
  EXPECT_EQ(all.rows[1].table, 0);
  EXPECT_EQ(all.rows[2].kind, MembraneKind::ridges);
  EXPECT_EQ(all.rows[2].table, 108000);
  EXPECT_EQ(all.tables.size(), 108000u + MembraneRidges<double>::value_count);
  const RestTriangle s = test::random_triangle(random, test::Deformation::random);
  EXPECT_EQ(stretching_energy(all, 2, s.x, s.inv_rest, s.area),
            membrane_law_energy(s.x, s.inv_rest, s.area, MembraneRidges<double>{tables[2].data()}));
}

}  // namespace
}  // namespace weft
