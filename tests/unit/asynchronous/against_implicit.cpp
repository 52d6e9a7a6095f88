// The same scene by both methods: they share the model and nothing else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/shapes.hpp"
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
  s.cloths.push_back(sheet(6, 0.0));
  s.pins.push_back({});
  s.pins[0].vertices = {0, 6};
  return s;
}

class AgainstImplicit : public testing::TestWithParam<Bending> {};

/// Without contact: implicit Euler comes nearer in proportion to its step, and BDF2 is so near that
/// what is left are the asynchronous method's own steps of up to a millisecond.
TEST_P(AgainstImplicit, MotionsMeetAsStepsShrink) {
  Scene s = swinging(GetParam());
  const auto mine = positions_after(s, "asynchronous", 0.01, 1);
  double before = 0;
  for (const double step : {4e-3, 2e-3, 1e-3}) {
    const double now = largest_difference(positions_after(s, "implicit", step, 1), mine);
    if (before > 0) {
      EXPECT_LT(now, 0.6 * before) << step;
    }
    before = now;
  }
  s.integrator = Integrator::bdf2;
  const auto exact = positions_after(s, "implicit", 1e-3, 1);
  double fallen = 0;
  for (const auto& x : exact) fallen = std::min(fallen, x[2]);
  EXPECT_LT(fallen, -0.03);
  EXPECT_LT(largest_difference(exact, mine), 5e-3 * -fallen);
}

INSTANTIATE_TEST_SUITE_P(Both, AgainstImplicit, testing::Values(Bending::plate, Bending::hinge));

/// A strip that is held on top of a rod and hangs down beside it: where it comes to rest does not
/// depend on how contacts push, but for the gap that they leave. With a gap that is larger by d its
/// end hangs d farther out, and, after a quarter of the way around, d pi / 2 higher.
TEST(AgainstImplicitAtRest, ShapesDifferByTheGap) {
  Scene s = asynchronous_scene();
  s.name = "over a rod";
  s.contact.thickness = 0.002;
  s.asynchronous.restitution = 0;
  s.materials[0].bending_stiffness = 1e-4;
  s.materials[0].damping_stiffness = 1e-3;
  s.materials[0].damping_mass = 4;
  s.time.frame_rate = 1;
  Cloth strip;
  strip.name = "strip";
  strip.mesh = make_grid({0.4, 0.1}, {12, 3}, Diagonals::alternating);
  for (auto& x : strip.mesh.positions) x = {x[0] + 0.2, x[1], 0.083};
  s.cloths.push_back(strip);
  Obstacle rod;
  rod.name = "rod";
  rod.mesh = make_capsule(0.08, 0.3, 6);
  rod.transform = {{0, 0, 0}, {1, 0, 0}, 1.5707963267948966, 1};
  rod.friction = 0;
  s.obstacles.push_back(rod);
  s.pins.push_back({});
  s.pins[0].vertices = {0, 13, 26, 39};
  const auto mine = positions_after(s, "asynchronous", 0.01, 3);
  const auto other = positions_after(s, "implicit", 0.01, 3);
  double lowest = 1;
  for (const auto& x : mine) lowest = std::min(lowest, x[2]);
  EXPECT_LT(lowest, -0.1) << "the end hangs down";
  // At the height of the axis it hangs free; above, edges touch the rod and not the vertices.
  std::size_t near = 0;
  for (const auto& x : mine) near += std::hypot(x[0], x[2]) < 0.085 ? 1 : 0;
  EXPECT_GE(near, 12u) << "it lies on the rod";
  EXPECT_LT(largest_difference(mine, other), (1 + 1.5708) * contact_thickness(s.contact));
}

}  // namespace
}  // namespace weft::test
