#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double step = 0.005;
constexpr double rate = 6;  // [rad/s]
constexpr int steps = 80;

/// Share of its kinetic energy that a sheet has left that spins about a diameter.
double energy_left(Integrator integrator) {
  Scene scene = test::thrown_sheet(0);
  scene.cloths.resize(1);
  scene.materials[0].damping_stiffness = 0;
  scene.cloths[0].angular_velocity = {0, rate, 0};
  scene.time.step = step;
  scene.integrator = integrator;
  scene.solver.newton_iterations = 1;
  Simulation simulation(scene, host_devices(1));
  const double start = simulation.energy().kinetic;
  for (int n = 0; n < steps; ++n) EXPECT_EQ(Failure::none, simulation.step().failure);
  return simulation.energy().kinetic / start;
}

/// Of a rigid body: v is the chord from x_n to x_{n+1}, and its moment about the centre is that of
/// the velocity before, both at x_{n+1}.
double rigid_energy_left() {
  double speed = rate * step;
  double lag = 0;  // of the velocity behind the tangent at x_n
  for (int n = 0; n < steps; ++n) {
    double angle = speed;
    for (int k = 0; k < 50; ++k) angle = std::asin(speed * std::cos(lag + angle));
    lag = angle / 2;
    speed = 2 * std::sin(angle / 2);
  }
  return std::pow(speed / (rate * step), 2);
}

TEST(Rotation, LosesAsMuchEnergyAsARigidBodyWithImplicitEuler) {
  EXPECT_NEAR(energy_left(Integrator::implicit_euler), rigid_energy_left(), 0.002);
}

TEST(Rotation, LosesHardlyAnyEnergyWithBdf2) {
  EXPECT_GT(energy_left(Integrator::bdf2), 0.995);
}

}  // namespace
}  // namespace weft
