#include "weft/elements/membrane_law.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "tests/unit/elements/sheets.hpp"

namespace weft {
namespace {

using test::Random;
using test::RestTriangle;

OrthotropicMembrane<double> random_law(Random& random) {
  const double warp = random.uniform(10, 1000), weft = random.uniform(10, 1000);
  const double nu = random.uniform(-0.9, 0.9) * std::sqrt(warp / weft);
  return orthotropic_membrane(warp, weft, nu, random.uniform(1, 300));
}

template <class Visit>
void each_case(const Visit& visit) {
  Random random(21);
  test::each_triangle(random, [&](const RestTriangle& s) { visit(s, random_law(random)); });
}

OrthotropicMembrane<test::Long> fine(const OrthotropicMembrane<double>& law) {
  return {law.c11, law.c12, law.c22, law.c33};
}

double stiffness(const OrthotropicMembrane<double>& law) {
  return std::max({law.c11, law.c22, law.c33});
}

TEST(OrthotropicMembrane, gradient_is_the_derivative_of_the_energy) {
  each_case([](const RestTriangle& s, const OrthotropicMembrane<double>& law) {
    test::expect_gradient(s, law, fine(law), stiffness(law));
  });
}

TEST(OrthotropicMembrane, hessian_is_the_derivative_of_the_gradient) {
  each_case([](const RestTriangle& s, const OrthotropicMembrane<double>& law) {
    test::expect_hessian(s, law, fine(law), stiffness(law));
  });
}

TEST(OrthotropicMembrane, projected_hessian_is_semidefinite_and_fused_form_the_same) {
  each_case([](const RestTriangle& s, const OrthotropicMembrane<double>& law) {
    test::expect_projection(s, law, stiffness(law));
    test::expect_fused(s, law);
  });
}

TEST(OrthotropicMembrane, energy_ignores_rotation_and_forces_carry_no_momentum) {
  Random random(22);
  each_case([&](const RestTriangle& s, const OrthotropicMembrane<double>& law) {
    test::expect_invariance(s, law, random, stiffness(law));
  });
}

TEST(OrthotropicMembrane, isotropic_is_a_special_case) {
  Random random(23);
  test::each_triangle(random, [&](const RestTriangle& s) {
    const double stiffness = random.uniform(10, 1000), nu = random.uniform(-0.3, 0.49);
    const auto plain = membrane_constants(stiffness, nu);
    const auto law = orthotropic_membrane(stiffness, stiffness, nu, stiffness / (2 * (1 + nu)));
    const double scale = test::stiffness_scale(s) * stiffness;
    EXPECT_NEAR(membrane_energy(s.x, s.inv_rest, s.area, plain),
                membrane_law_energy(s.x, s.inv_rest, s.area, law), 1e-14 * s.area * stiffness);
    Vec3<double> g[3], g_law[3];
    Mat3<double> h[6], h_law[6];
    membrane_gradient(s.x, s.inv_rest, s.area, plain, g);
    membrane_law_gradient(s.x, s.inv_rest, s.area, law, g_law);
    EXPECT_LE(test::largest_difference(g, g_law), 1e-14 * scale * 0.02);
    for (const bool project : {false, true}) {
      membrane_hessian(s.x, s.inv_rest, s.area, plain, project, h);
      membrane_law_hessian(s.x, s.inv_rest, s.area, law, project, h_law);
      for (int b = 0; b < 6; ++b)
        for (int k = 0; k < 9; ++k) EXPECT_NEAR(h[b].e[k], h_law[b].e[k], 1e-13 * scale);
    }
  });
}

TEST(OrthotropicMembrane, pull_along_either_thread_costs_its_own_modulus) {
  const double warp = 900, weft = 300, nu = 0.4, strain = 0.02;
  const auto law = orthotropic_membrane(warp, weft, nu, 50.0);
  const double nu_back = nu * weft / warp;
  // Lateral Green strains -nu strain and -nu' strain leave the sides free.
  EXPECT_NEAR(law.energy({strain, 0, -nu * strain}), warp / 2 * strain * strain, 1e-14);
  EXPECT_NEAR(law.energy({-nu_back * strain, 0, strain}), weft / 2 * strain * strain, 1e-14);
  EXPECT_NEAR(law.response({strain, 0, -nu * strain}, false).stress.yy, 0, 1e-13);
  EXPECT_NEAR(law.response({-nu_back * strain, 0, strain}, false).stress.xx, 0, 1e-13);
  // A simple shear by gamma has G01 = gamma / 2.
  EXPECT_NEAR(law.energy({0, 0.01 / 2, 0}), 50.0 / 2 * 1e-4, 1e-16);
}

}  // namespace
}  // namespace weft
