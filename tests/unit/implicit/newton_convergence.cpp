#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/lab/check/validator.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// A drum: a sheet that is held stretched along its outline and thrown across itself.
Scene drum(int newton_iterations) {
  Scene scene;
  scene.precision = Precision::double_precision;
  scene.time.step = 0.02;
  scene.solver.tolerance = 1e-10;
  scene.solver.newton_iterations = newton_iterations;
  scene.solver.newton_tolerance = 1e-15;
  scene.materials.push_back({});
  Cloth cloth;
  cloth.name = "drum";
  cloth.mesh = make_grid({0.4, 0.4}, {10, 10}, Diagonals::alternating);
  cloth.velocity = {0, 0, 5};
  Pin outline;
  for (std::size_t v = 0; v < cloth.mesh.positions.size(); ++v) {
    Vec3<double>& x = cloth.mesh.positions[v];
    if (std::abs(x[0]) > 0.1999 || std::abs(x[1]) > 0.1999)
      outline.vertices.push_back(static_cast<Index>(v));
    x = 1.1 * x;
  }
  scene.cloths.push_back(cloth);
  scene.pins.push_back(outline);
  return scene;
}

/// Where nothing is compressed, Jacobians are exact: every residual is at most a constant times the
/// square of the one before, down to rounding. A missing derivative would make that a constant
/// times the one before.
TEST(NewtonConvergence, IsQuadraticWhereNothingIsCompressed) {
  constexpr double constant = 60;  // 48 is the largest ratio that was measured, 42 the last ones
  constexpr double rounding = 1e-14;
  double before = 0;
  int quadratic = 0;
  for (int iterations = 2; iterations <= 10; ++iterations) {
    Simulation simulation(drum(iterations), host_devices(1));
    const StepReport report = simulation.step();
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
    ASSERT_EQ(report.line_steps, 0);
    const double residual = report.newton_residual;
    if (before > 0) {
      EXPECT_LE(residual, std::max(constant * before * before, rounding))
          << iterations << " iterations; before: " << before;
    }
    // Only then is it less than a linear rate would allow.
    if (constant * before < 0.1 && before > rounding) ++quadratic;
    before = residual;
    if (iterations < 10) continue;
    Mesh mesh = simulation.scene().cloths[0].mesh;
    mesh.positions = simulation.frame().cloth_positions[0];
    EXPECT_GT(lab::validate(mesh, nullptr).strain.smallest.min, 0) << "something is compressed";
  }
  EXPECT_LE(before, rounding) << "not converged";
  EXPECT_GE(quadratic, 3);
}

}  // namespace
}  // namespace weft
