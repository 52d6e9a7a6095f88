// What StepReport says of the work that is done on cloth, against what the cloth has gained.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double side = 0.4;      // [m] of test::sheet
constexpr double density = 0.15;  // [kg/m^2] of test::cotton
constexpr double mass = density * side * side;

/// A sheet alone.
Scene sheet_scene() {
  Scene s;
  s.precision = Precision::double_precision;
  s.materials.push_back(test::cotton());
  s.contact.thickness = 0.002;
  s.solver.partial_rows = 8;
  s.solver.tolerance = 1e-8;
  s.time.step = 0.005;
  s.cloths.push_back(test::sheet(8, 0));
  return s;
}

struct Outcome {
  double work = 0;      ///< [J] of all steps
  double gain = 0;      ///< [J] of energy since the start
  double unpaid = 0;    ///< [J] most that a step gained beyond its work
  double smallest = 0;  ///< [J] least work of a step
};

Outcome run(const Scene& scene, int steps, int ranks = 1) {
  Simulation simulation(scene, host_devices(ranks));
  Outcome o;
  double before = simulation.energy().total();
  for (int n = 0; n < steps; ++n) {
    const StepReport report = simulation.step();
    EXPECT_EQ(report.failure, Failure::none) << report.failure_detail;
    EXPECT_TRUE(report.work.has_value());
    const double after = simulation.energy().total();
    const double work = report.work.value_or(0);
    o.work += work;
    o.gain += after - before;
    o.unpaid = std::max(o.unpaid, after - before - work);
    o.smallest = std::min(o.smallest, work);
    before = after;
  }
  return o;
}

TEST(ExternalWork, GravityIsNone) {
  Scene s = sheet_scene();
  EXPECT_EQ(run(s, 10).work, 0);
}

TEST(ExternalWork, PinsThatCarryAllOfACloth) {
  Scene s = sheet_scene();
  Pin pin;
  for (Index v = 0; v < 81; ++v) pin.vertices.push_back(v);
  pin.motion = {{0, {}}, {0.1, {{0, 0.03, 0.05}, {0, 0, 1}, 0, 1}}};
  s.pins = {pin};
  const Outcome o = run(s, 20);
  const double lifted = mass * 9.81 * 0.05;
  EXPECT_NEAR(o.work, lifted, 0.01 * lifted);  // pins come to rest smoothly
  EXPECT_NEAR(o.gain, o.work, 1e-9);
}

/// Pulled apart slowly, a sheet has the work of its pins as elastic energy.
TEST(ExternalWork, PinsThatStretch) {
  for (const int iterations : {1, 20}) {
    Scene s = sheet_scene();
    s.gravity = {0, 0, 0};
    s.solver.newton_iterations = iterations;
    Pin held, pulled;
    for (Index v = 0; v < 9; ++v) {
      held.vertices.push_back(9 * v);
      pulled.vertices.push_back(9 * v + 8);
    }
    pulled.motion = {{0, {}}, {1, {{0.04, 0, 0}, {0, 0, 1}, 0, 1}}};
    s.pins = {held, pulled};
    const Outcome o = run(s, 200);
    EXPECT_GT(o.work, 0.05);
    EXPECT_NEAR(o.gain, o.work, 0.05 * o.work);
    EXPECT_LT(o.unpaid, 1e-4 * o.work);
  }
}

/// A box whose top is at z = 0 at first.
/// @param rise [m]   @param duration [s]
Obstacle rising_box(double rise, double duration) {
  Obstacle box;
  box.name = "box";
  box.mesh = make_box({0.6, 0.6, 0.1}, {2, 2, 1});
  box.motion = {{0, {{0, 0, -0.05}, {0, 0, 1}, 0, 1}},
                {duration, {{0, 0, rise - 0.05}, {0, 0, 1}, 0, 1}}};
  return box;
}

/// A box that lifts a sheet gives it its potential energy.
TEST(ExternalWork, ABodyThatLifts) {
  Scene s = sheet_scene();
  s.cloths[0].mesh = test::sheet(8, 0.0019).mesh;
  s.obstacles = {rising_box(0.2, 0.5)};
  const Outcome o = run(s, 100);
  const double lifted = mass * 9.81 * 0.2;
  EXPECT_NEAR(o.work, lifted, 0.15 * lifted);
  EXPECT_LT(o.gain, o.work);
}

/// A body that is pushed into cloth so fast that impact zones have to hold it.
TEST(ExternalWork, ABodyThatStrikes) {
  Scene s = sheet_scene();
  s.gravity = {0, 0, 0};
  s.contact.thickness = 1e-4;
  s.cloths[0].mesh = test::sheet(8, 0.01).mesh;
  s.obstacles = {rising_box(1, 0.1)};
  const Outcome o = run(s, 20);
  // Inelastic: a body gives twice what cloth keeps.
  EXPECT_GT(o.gain, 0.4 * mass * 10 * 10);
  EXPECT_GE(o.work, 0.9 * o.gain);
  EXPECT_LT(o.work, 3 * o.gain);
}

TEST(ExternalWork, HandlesThatLift) {
  Scene s = sheet_scene();
  Handle handle;
  for (Index v = 0; v < 81; ++v) handle.vertices.push_back(v);
  handle.stiffness = 50;
  handle.motion = {{0, {}}, {0.5, {{0, 0, 0.2}, {0, 0, 1}, 0, 1}}};
  s.handles = {handle};
  const Outcome o = run(s, 120);
  const double lifted = mass * 9.81 * 0.2;
  EXPECT_NEAR(o.work, lifted, 0.1 * lifted);
  EXPECT_LT(o.unpaid, 1e-3 * lifted);
}

/// A handle that grasps cloth at a distance has all of its spring's energy to give.
TEST(ExternalWork, AHandleThatGrasps) {
  Scene s = sheet_scene();
  s.gravity = {0, 0, 0};
  Handle handle;
  handle.vertices = {0};
  handle.stiffness = 20;
  handle.start_time = 0.02;
  const Transform aside{{0, 0, 0.1}, {0, 0, 1}, 0, 1};
  handle.motion = {{0, aside}, {1, aside}};
  s.handles = {handle};
  const Outcome o = run(s, 5);
  EXPECT_NEAR(o.work, 0.5 * 20 * 0.1 * 0.1, 1e-9);
  EXPECT_LE(o.unpaid, 1e-9);
}

TEST(ExternalWork, WindThatBlowsASheetAway) {
  Scene s = sheet_scene();
  s.gravity = {0, 0, 0};
  s.wind.density = 1.2;
  s.wind.velocity = {0, 0, 5};
  const Outcome o = run(s, 40);
  EXPECT_GT(o.gain, 0.1 * mass * 5 * 5 / 2);
  EXPECT_GE(o.work, o.gain);
  EXPECT_LT(o.work, 1.2 * o.gain);
  EXPECT_LE(o.unpaid, 1e-9);
}

TEST(ExternalWork, PressureThatPushesASheet) {
  Scene s = sheet_scene();
  s.gravity = {0, 0, 0};
  s.cloths[0].pressure = 2;
  const Outcome o = run(s, 40);
  const double speed = 2 / density * 0.2;
  EXPECT_NEAR(o.gain, mass * speed * speed / 2, 1e-3 * o.gain);
  EXPECT_GE(o.work, o.gain);
  EXPECT_LT(o.work, 1.1 * o.gain);
}

TEST(ExternalWork, TheSameForAnyNumberOfRanks) {
  Scene s = test::two_sheets(Precision::single_precision);
  s.obstacles[0].motion = {{0, {{0, 0, -0.054}, {0, 0, 1}, 0, 1}},
                           {0.05, {{0, 0.01, -0.02}, {0, 0, 1}, 0.3, 1}}};
  Pin pin;
  pin.vertices = {0, 1, 2};
  pin.motion = {{0, {}}, {0.05, {{0, 0, 0.02}, {0, 0, 1}, 0, 1}}};
  s.pins = {pin};
  s.wind.density = 1.2;
  s.wind.velocity = {0, 0, 5};
  s.cloths[1].pressure = 2;
  const Outcome one = run(s, 12);
  EXPECT_NE(one.work, 0);
  for (const int ranks : {2, 5}) EXPECT_EQ(run(s, 12, ranks).work, one.work);
}

}  // namespace
}  // namespace weft
