#include "host/scene/fabric/rigidity.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "host/model/material_rows.hpp"
#include "host/scene/validate.hpp"

namespace weft {
namespace {

double energy(const Mat3<double>& d, double k11, double k22, double k12) {
  const Vec3<double> k{k11, k22, k12};
  return dot(k, d * k) / 2;
}

TEST(Rigidity, IsotropicEnergyIsThatOfAPlate) {
  Material m;
  m.bending_stiffness = 3e-5;
  m.poisson_ratio = 0.3;
  // D/2 ((k1 + k2)^2 - 2 (1 - nu) k1 k2) of a curvature tensor that is not diagonal
  const double a = 7, b = -2, c = 3;
  EXPECT_NEAR(energy(bending_rigidity(m), a, b, c),
              3e-5 / 2 * (std::pow(a + b, 2) - 2 * 0.7 * (a * b - c * c)), 1e-17);
  EXPECT_EQ(mean_bending_stiffness(m), 3e-5);
}

TEST(Rigidity, DirectionsGiveTheirOwnStiffness) {
  // the last is softer halfway than any twist of 0 could make it
  for (const double halfway : {3e-5, 1.2e-5, 0.2e-5}) {
    Material m;
    m.orthotropic_bending = directional_bending(2e-5, 1.5e-5, halfway);
    const Mat3<double> d = bending_rigidity(m);
    EXPECT_NEAR(energy(d, 5, 0, 0), 2e-5 / 2 * 25, 1e-16);
    EXPECT_NEAR(energy(d, 0, 5, 0), 1.5e-5 / 2 * 25, 1e-16);
    // curvature 5 along a diagonal
    EXPECT_NEAR(energy(d, 2.5, 2.5, 2.5), halfway / 2 * 25, 1e-16);
    EXPECT_NEAR(energy(d, 2.5, 2.5, -2.5), halfway / 2 * 25, 1e-16);
    EXPECT_NO_THROW(validate_material(m, "", ""));
  }
  const OrthotropicBending even = directional_bending(2e-5, 2e-5, 2e-5);
  EXPECT_EQ(even.coupling, 0);
  EXPECT_NEAR(even.twist, 1e-5, 1e-20);
}

TEST(Rigidity, HuberIsExactForIsotropicSheets) {
  Material plain;
  plain.bending_stiffness = 3e-5;
  plain.poisson_ratio = 0.3;
  Material threads;
  threads.orthotropic_bending = huber_bending(3e-5, 3e-5, 0.3);
  const Mat3<double> a = bending_rigidity(plain), b = bending_rigidity(threads);
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(a.e[i], b.e[i], 1e-19) << i;
  EXPECT_NEAR(mean_bending_stiffness(threads), 3e-5, 1e-19);
}

TEST(Rigidity, OrthotropicEnergyAndItsMean) {
  Material m;
  m.orthotropic_bending = {8e-5, 2e-5, 1e-5, 1.5e-5};
  EXPECT_NEAR(energy(bending_rigidity(m), 3, 5, 7),
              4e-5 * 9 + 1e-5 * 25 + 1e-5 * 15 + 2 * 1.5e-5 * 49, 1e-17);
  double sum = 0;
  constexpr int count = 16;  // exact for the fourth powers of a sine
  for (int i = 0; i < count; ++i) {
    const double c = std::cos(M_PI * i / count), s = std::sin(M_PI * i / count);
    sum += 2 * energy(bending_rigidity(m), c * c, s * s, c * s);
  }
  EXPECT_NEAR(mean_bending_stiffness(m), sum / count, 1e-18);
}

TEST(Rigidity, StretchRowsOfBothKinds) {
  Material plain, threads;
  plain.stretch_stiffness = 500;
  plain.poisson_ratio = 0.2;
  plain.damping_stiffness = threads.damping_stiffness = 0.25;
  threads.orthotropic = OrthotropicStretch{900, 300, 0.4, 50};
  const auto rows = material_rows<double>({plain, threads}, {{}, {}}).rows;
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].kind, MembraneKind::isotropic);
  EXPECT_EQ(rows[0].membrane.mu, membrane_constants(500.0, 0.2).mu);
  EXPECT_EQ(rows[1].kind, MembraneKind::orthotropic);
  EXPECT_EQ(rows[1].damping_stiffness, 0.25);
  // the compliance of a sheet with threads, inverted: 1 / warp, -nu / warp, 1 / weft
  Eigen::Matrix2d compliance;
  compliance << 1 / 900.0, -0.4 / 900, -0.4 / 900, 1 / 300.0;
  const Eigen::Matrix2d c = compliance.inverse();
  EXPECT_NEAR(rows[1].orthotropic.c11, c(0, 0), 1e-10);
  EXPECT_NEAR(rows[1].orthotropic.c12, c(0, 1), 1e-10);
  EXPECT_NEAR(rows[1].orthotropic.c22, c(1, 1), 1e-10);
  EXPECT_EQ(rows[1].orthotropic.c33, 100);
}

}  // namespace
}  // namespace weft
