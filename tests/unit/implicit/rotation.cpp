#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double step = 0.005;
constexpr double rate = 6;  // [rad/s]
constexpr int steps = 80;

/// A sheet that spins about a diameter.
Scene spun_sheet() {
  Scene scene = test::thrown_sheet(0);
  scene.cloths.resize(1);
  scene.materials[0].damping_stiffness = 0;
  scene.cloths[0].angular_velocity = {0, rate, 0};
  return scene;
}

/// One that spins in its plane, on a small ball without friction.
Scene sheet_on_ball() {
  Scene scene = spun_sheet();
  scene.cloths[0] = test::sheet(8, 0);
  scene.cloths[0].angular_velocity = {0, 0, rate};
  scene.contact.friction = 0;
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.05, 2);
  for (Vec3<double>& x : ball.mesh.positions) x[2] -= 0.051;
  scene.obstacles = {ball};
  return scene;
}

/// Share of its kinetic energy that a sheet has left.
double energy_left(Scene scene, Integrator integrator) {
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
  EXPECT_NEAR(energy_left(spun_sheet(), Integrator::implicit_euler), rigid_energy_left(), 0.002);
}

TEST(Rotation, LosesHardlyAnyEnergyWithBdf2) {
  EXPECT_GT(energy_left(spun_sheet(), Integrator::bdf2), 0.995);
}

TEST(Rotation, LosesNoMoreIfTheSheetTouchesSomething) {
  EXPECT_NEAR(energy_left(sheet_on_ball(), Integrator::implicit_euler), rigid_energy_left(), 0.02);
  EXPECT_GT(energy_left(sheet_on_ball(), Integrator::bdf2), 0.98);
}

}  // namespace
}  // namespace weft
