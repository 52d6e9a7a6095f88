#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// A sheet that flies through space, away from the origin, so that positions are rounded.
Scene flight(Precision precision) {
  Scene s;
  s.precision = precision;
  s.gravity = {0, 0, 0};
  s.materials.push_back(test::cotton());
  s.cloths.push_back(test::sheet(12, 0.7));
  s.cloths[0].velocity = {0.75, 0.5, -1};
  for (auto& p : s.cloths[0].mesh.positions) p += Vec3<double>{0.3, 0.6, 0.1};
  s.time.step = 0.005;
  s.time.frame_rate = 200;
  return s;
}

/// How far the sheet is from where it would be if every step did what the scene says. [m]
double error_after(const Scene& s, int steps, const Vec3<double>& way) {
  Simulation simulation(s, host_devices(2));
  for (int k = 0; k < steps; ++k) {
    const StepReport report = simulation.step();
    EXPECT_EQ(Failure::none, report.failure) << "step " << k;
    EXPECT_EQ(FallbackLevel::whole, report.fallback_level) << "step " << k;
  }
  double error = 0;
  const auto x = simulation.frame().cloth_positions[0];
  for (std::size_t v = 0; v < x.size(); ++v)
    error = std::max(error, length(x[v] - s.cloths[0].mesh.positions[v] - way));
  return error;
}

/// Nothing acts on it: all that is left to solve for is what rounding makes of forces that cancel.
TEST(Rounding, FlightWithoutForcesInFloat) {
  EXPECT_LT(error_after(flight(Precision::single_precision), 20, {0.075, 0.05, -0.1}), 2e-5);
}
TEST(Rounding, FlightWithoutForcesInDouble) {
  EXPECT_LT(error_after(flight(Precision::double_precision), 20, {0.075, 0.05, -0.1}), 1e-12);
}

/// What the tolerance asks for is below what rounding makes of stretching that is far stiffer than
/// what gravity and inertia do in a step.
TEST(Rounding, StiffSheetFalls) {
  Scene s = flight(Precision::double_precision);
  s.gravity = {0, 0, -10};
  s.materials[0].stretch_stiffness = 1e6;
  s.materials[0].damping_stiffness = 0;
  s.solver.tolerance = 1e-13;
  const double fall = -10 * 0.005 * 0.005 * 20 * 21 / 2;
  EXPECT_LT(error_after(s, 20, {0.075, 0.05, -0.1 + fall}), 1e-8);
}

/// Triangles so small that what rounding leaves of stiffness times the speed of the whole would be
/// several times their weight.
TEST(Rounding, SmallTrianglesThatFlyFall) {
  Scene s = flight(Precision::single_precision);
  s.gravity = {0, 0, -10};
  s.cloths[0] = test::sheet(24, 0.04);
  s.cloths[0].velocity = {3, 2, -10};
  // Twice the solve's tolerance of the fall.
  const double fall = -10 * 0.005 * 0.005 * 20 * 21 / 2;
  EXPECT_LT(error_after(s, 20, {0.3, 0.2, -1 + fall}), -2e-3 * fall);
}

/// Sheets of which rounding would hide the weight many times over, lying and tilted: what is stiff
/// in their plane has components in all directions then.
TEST(Rounding, StiffAndLightSheetsFallFreelyInFloat) {
  const double fall = -10 * 0.005 * 0.005 * 6 * 7 / 2;
  for (const double angle : {0.0, 0.6})
    for (const auto& [stiffness, density] : {std::pair{1e8, 0.15},
                                             {1e10, 0.15},
                                             {1e12, 0.15},
                                             {800.0, 1e-9},
                                             {800.0, 1e-6},
                                             {800.0, 1e9}}) {
      SCOPED_TRACE(std::to_string(stiffness) + " N/m, " + std::to_string(density) +
                   " kg/m2, tilted by " + std::to_string(angle));
      Scene s = flight(Precision::single_precision);
      s.gravity = {0, 0, -10};
      s.materials[0].stretch_stiffness = stiffness;
      s.materials[0].density = density;
      for (auto& p : s.cloths[0].mesh.positions)
        p = {std::cos(angle) * p[0] - std::sin(angle) * p[2], p[1],
             std::sin(angle) * p[0] + std::cos(angle) * p[2]};
      EXPECT_LT(error_after(s, 6, {0.0225, 0.015, -0.03 + fall}), -2e-3 * fall);
    }
}

/// In single precision rounding hides much of what gravity does to such a sheet, which turns too
/// slowly to be linearised about its end: that is no solution, and is not taken for one.
TEST(Rounding, GravityThatRoundingHidesIsRefused) {
  Scene s = flight(Precision::single_precision);
  s.cloths[0].angular_velocity = {0, 0, 0.15};
  s.gravity = {0, 0, -10};
  s.materials[0].stretch_stiffness = 1e9;
  s.materials[0].damping_stiffness = 0;
  s.solver.tolerance = 1e-6;
  s.contact.substep_bisections = 0;
  Simulation simulation(s, host_devices(1));
  Failure failure = Failure::none;
  for (int k = 0; k < 20 && failure == Failure::none; ++k) failure = simulation.step().failure;
  EXPECT_EQ(Failure::not_converged, failure);
}

/// Rotation is no strain, so that nothing hides the weight of a stiff sheet that turns.
TEST(Rounding, StiffSheetsThatTurnFallFreelyInFloat) {
  Scene s = flight(Precision::single_precision);
  s.cloths[0].velocity = {};
  s.cloths[0].angular_velocity = {0, 0, 5};
  s.gravity = {0, 0, -10};
  s.materials[0].stretch_stiffness = 1e8;
  s.materials[0].damping_stiffness = 0;
  Simulation simulation(s, host_devices(1));
  double fall = 0;
  for (int n = 1; n <= 20; ++n) {
    ASSERT_EQ(Failure::none, simulation.step().failure);
    fall += n * s.time.step * s.time.step * 10;
  }
  double mean = 0;
  const auto x = simulation.frame().cloth_positions[0];
  for (std::size_t v = 0; v < x.size(); ++v)
    mean += (s.cloths[0].mesh.positions[v][2] - x[v][2]) / static_cast<double>(x.size());
  EXPECT_NEAR(mean, fall, 1e-3 * fall);
}

}  // namespace
}  // namespace weft
