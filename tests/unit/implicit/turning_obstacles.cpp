// Obstacles that turn so far within a step that their contacts would miss them.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double radius = 0.4;

/// A sheet that falls onto a ball, or towards it, which turns about an axis at a steady rate.
/// @param angle  [rad] in a step, below a right angle   @param height [m] of the sheet above the
/// ball
Scene on_ball(double angle, const Vec3<double>& axis, double height) {
  Scene s;
  s.materials = {test::cotton()};
  s.cloths = {test::sheet(4, height)};
  s.cloths[0].velocity = {0, 0, -1};
  s.time.step = 0.005;
  s.precision = Precision::double_precision;
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(radius, 3);
  double top = 0;
  for (const Vec3<double>& x : ball.mesh.positions) top = std::max(top, x[2]);
  // Keys close enough that each turn is less than a half one.
  for (int k = -8; k <= 8; ++k) {
    Keyframe key;
    key.time = 0.005 * k;
    key.transform.translate = {0, 0, -top};
    key.transform.rotation_axis = axis;
    key.transform.rotation_angle = angle * k;
    ball.motion.push_back(key);
  }
  s.obstacles = {ball};
  return s;
}

/// In how many parts the first step is taken.
int parts(const Scene& scene) {
  Simulation simulation(scene, host_devices(1));
  const StepReport report = simulation.step();
  EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
  EXPECT_EQ(report.newton_iterations > 1 ? FallbackLevel::halved : FallbackLevel::whole,
            report.fallback_level);
  return report.newton_iterations;
}

constexpr Vec3<double> sideways{1, 0, 0};

// Contacts near the top of the ball are left by radius angle^2 / 2, which may be half a millimetre.
TEST(TurningObstacles, HalveStepsUntilTheyLeaveTheirContactsByLessThanHalfTheThickness) {
  const double allowed = std::sqrt(2 * 0.0005 / radius);
  EXPECT_EQ(1, parts(on_ball(0.9 * allowed, sideways, 0.0011)));
  EXPECT_EQ(2, parts(on_ball(1.1 * allowed, sideways, 0.0011)));
  EXPECT_EQ(2, parts(on_ball(1.9 * allowed, sideways, 0.0011)));
  EXPECT_EQ(4, parts(on_ball(2.2 * allowed, sideways, 0.0011)));
}

TEST(TurningObstacles, DoNotMatterToClothThatTheyDoNotTouch) {
  EXPECT_EQ(1, parts(on_ball(0.5, sideways, 0.1)));
}

TEST(TurningObstacles, TurnOnWhereStepsMayNotBeHalved) {
  Scene s = on_ball(0.5, sideways, 0.0011);
  s.contact.substep_bisections = 0;
  EXPECT_EQ(1, parts(s));
}

/// A turntable stays in the planes of its contacts.
TEST(TurningObstacles, MayTurnAboutTheNormalOfTheirContacts) {
  Scene s = on_ball(0.3, {0, 0, 1}, 0.0011);
  Obstacle& table = s.obstacles[0];
  table.mesh = make_disc(0.5, 6);
  for (Keyframe& key : table.motion) key.transform.translate = {};
  EXPECT_EQ(1, parts(s));
}

/// A wall stays in them too, however fast it slides.
TEST(TurningObstacles, MaySlide) {
  Scene s = on_ball(0, {0, 0, 1}, 0.0011);
  Obstacle& belt = s.obstacles[0];
  belt.mesh = make_grid({8, 8}, {16, 16}, Diagonals::alternating);
  for (Keyframe& key : belt.motion) key.transform.translate = {60 * key.time, 0, 0};
  EXPECT_EQ(1, parts(s));
}

}  // namespace
}  // namespace weft
