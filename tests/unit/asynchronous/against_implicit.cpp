// The same scene by both methods: they share the model and nothing else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/scene/procedural.hpp"
#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

std::vector<Vec3<double>> positions_after(Scene scene, const std::string& method, double step,
                                          int frames) {
  scene.method = method;
  if (method == "asynchronous") scene.integrator = Integrator::implicit_euler;
  scene.time.step = step;
  Simulation simulation(scene, host_devices(1));
  while (simulation.frame_number() < frames) {
    const StepReport report = simulation.step();
    EXPECT_EQ(report.failure, Failure::none) << method << ": " << report.failure_detail;
    if (report.failure != Failure::none) break;
  }
  return simulation.frame().cloth_positions.front();
}

double largest_difference(const std::vector<Vec3<double>>& a, const std::vector<Vec3<double>>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, length(a[i] - b[i]));
  return most;
}

/// A sheet that swings down from two corners, away from its plane.
Scene swinging(Bending bending) {
  Scene s = asynchronous_scene();
  s.name = "swinging";
  s.bending = bending;
  s.materials[0].damping_stiffness = 1e-4;
  s.materials[0].damping_mass = 0.3;
  s.time.frame_rate = 10;
  s.solver.tolerance = 1e-10;
  s.solver.newton_iterations = 30;
  s.solver.newton_tolerance = 1e-9;
  s.integrator = Integrator::bdf2;
  s.cloths.push_back(sheet(6, 0.0));
  s.pins.push_back({});
  s.pins[0].vertices = {0, 6};
  return s;
}

class AgainstImplicit : public testing::TestWithParam<Bending> {};

/// Without contact both go to the same motion as steps shrink; the asynchronous method's own steps
/// are below the implicit ones here.
TEST_P(AgainstImplicit, MotionsMeetAsStepsShrink) {
  const Scene s = swinging(GetParam());
  const auto mine = positions_after(s, "asynchronous", 0.01, 1);
  double before = 0;
  for (const double step : {2e-3, 1e-3, 5e-4}) {
    const double now = largest_difference(positions_after(s, "implicit", step, 1), mine);
    if (before > 0) {
      EXPECT_LT(now, 0.5 * before) << step;
    }
    before = now;
  }
  // The sheet has fallen by some 5 cm.
  EXPECT_LT(before, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Both, AgainstImplicit, testing::Values(Bending::plate, Bending::hinge));

/// A strip that is held at one end and lies over a ball: where it comes to rest does not depend on
/// how contacts push, up to their thickness.
TEST(AgainstImplicitAtRest, ShapesDifferByLessThanTheThickness) {
  Scene s = asynchronous_scene();
  s.name = "over a ball";
  s.contact.thickness = 0.002;
  s.asynchronous.restitution = 0;
  s.materials[0].bending_stiffness = 1e-4;
  s.materials[0].damping_stiffness = 1e-3;
  s.materials[0].damping_mass = 4;
  s.time.frame_rate = 1;
  Cloth strip;
  strip.name = "strip";
  strip.mesh = make_grid({0.4, 0.1}, {12, 3}, Diagonals::alternating);
  for (auto& x : strip.mesh.positions) x[2] = 0.083;
  s.cloths.push_back(strip);
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.08, 3);
  ball.friction = 0;
  s.obstacles.push_back(ball);
  s.pins.push_back({});
  s.pins[0].vertices = {0, 13, 26, 39};
  const auto mine = positions_after(s, "asynchronous", 0.01, 3);
  const auto other = positions_after(s, "implicit", 0.01, 3);
  double lowest = 1, touching = 1;
  for (const auto& x : mine) {
    lowest = std::min(lowest, x[2]);
    touching = std::min(touching, length(x));
  }
  EXPECT_LT(lowest, 0.0) << "the free end hangs down beside the ball";
  EXPECT_LT(touching, 0.083);
  EXPECT_LT(largest_difference(mine, other), s.contact.thickness);
}

}  // namespace
}  // namespace weft::test
