#include "weft/elements/buckling.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/elements/sheets.hpp"

namespace weft {
namespace {

using test::Random;
using test::RestTriangle;
using Strain = detail::Symmetric2<double>;

Strain along(double angle, double g1, double g2) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {g1 * c * c + g2 * s * s, (g1 - g2) * c * s, g1 * s * s + g2 * c * c};
}

void expect_near(const Strain& a, const Strain& b) {
  EXPECT_NEAR(a.xx, b.xx, 1e-15);
  EXPECT_NEAR(a.xy, b.xy, 1e-15);
  EXPECT_NEAR(a.yy, b.yy, 1e-15);
}

/// Equation (10), principal strain by principal strain.
TEST(Buckling, StrainLosesItsCompressionOnly) {
  for (const double angle : {0.0, 0.6, 1.9}) {
    expect_near(buckled_strain(along(angle, 0.1, -0.2), 0.25), along(angle, 0.1, -0.05));
    expect_near(buckled_strain(along(angle, 0.1, 0.03), 0.25), along(angle, 0.1, 0.03));
    expect_near(buckled_strain(along(angle, -0.1, -0.2), 0.25), along(angle, -0.025, -0.05));
    expect_near(buckled_strain(along(angle, 0.1, -0.2), 0.0), along(angle, 0.1, 0));
    expect_near(buckled_strain(along(angle, 0.1, -0.2), 1.0), along(angle, 0.1, -0.2));
  }
}

TEST(Buckling, EnergyAndStressByHand) {
  const BuckledLaw<double, OrthotropicMembrane<double>> law{{3, 1, 3, 2}, 0.25};
  const Strain g{0.1, 0, -0.2};
  // seen (0.1, -0.05): 3 / 2 (0.01 + 0.0025) - 0.005
  EXPECT_NEAR(law.energy(g), 0.01375, 1e-16);
  const auto r = law.response(g, false);
  EXPECT_NEAR(r.stress.xx, 0.25, 1e-15);
  EXPECT_NEAR(r.stress.yy, 0.25 * -0.05, 1e-15);
  EXPECT_NEAR(r.stress.xy, 0, 1e-15);
  EXPECT_NEAR(r.tangent[0], 3, 1e-14);
  EXPECT_NEAR(r.tangent[1], 0.25, 1e-14);
  EXPECT_NEAR(r.tangent[3], 3 * 0.25 * 0.25, 1e-14);
  // An isotropic law (c33 = c11 - c12) stays one: the shear follows from turning the stress,
  // (S1 - S2) / (2 (g1 - g2)).
  EXPECT_NEAR(r.tangent[5], (0.25 + 0.0125) / (2 * 0.3), 1e-14);
}

struct Case {
  double c[4];
  double beta;
  template <class T>
  BuckledLaw<T, OrthotropicMembrane<T>> law() const {
    return {
        {static_cast<T>(c[0]), static_cast<T>(c[1]), static_cast<T>(c[2]), static_cast<T>(c[3])},
        static_cast<T>(beta)};
  }
};

template <class Visit>
void each_case(const Visit& visit) {
  Random random(33);
  int turn = 0;
  const double betas[] = {0, 0.03, 0.5, 1};
  test::each_triangle(random, [&](const RestTriangle& s) {
    visit(s, Case{{random.uniform(200, 1000), random.uniform(0, 100), random.uniform(200, 1000),
                   random.uniform(50, 500)},
                  betas[turn++ % 4]});
  });
}

constexpr double step = 1e-8;

TEST(Buckling, gradient_is_the_derivative_of_the_energy) {
  each_case([](const RestTriangle& s, const Case& c) {
    test::expect_gradient(s, c.law<double>(), c.law<test::Long>(), 1000, step, 1e-8);
  });
}

TEST(Buckling, hessian_is_the_derivative_of_the_gradient) {
  each_case([](const RestTriangle& s, const Case& c) {
    test::expect_hessian(s, c.law<double>(), c.law<test::Long>(), 1000, step, 1e-6);
  });
}

TEST(Buckling, projected_hessian_is_semidefinite_and_fused_form_the_same) {
  each_case([](const RestTriangle& s, const Case& c) {
    Mat3<double> h[6];
    membrane_law_hessian(s.x, s.inv_rest, s.area, c.law<double>(), true, h);
    EXPECT_GE(test::least_eigenvalue(test::matrix_of(h)), -1e-12 * 1000 * test::stiffness_scale(s));
    test::expect_fused(s, c.law<double>());
  });
}

TEST(Buckling, energy_ignores_rotation_and_forces_carry_no_momentum) {
  Random random(34);
  each_case([&](const RestTriangle& s, const Case& c) {
    test::expect_invariance(s, c.law<double>(), random, 1000);
  });
}

}  // namespace
}  // namespace weft
