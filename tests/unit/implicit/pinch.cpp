#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "host/scene/intersection_check.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

Obstacle box(const char* name, double start, double end) {
  Obstacle o;
  o.name = name;
  o.mesh = make_box({0.2, 0.2, 0.1}, {4, 4, 2});
  o.motion = {{0, {{0, 0, start}}}, {0.4, {{0, 0, end}}}, {0.8, {{0, 0, start}}}};
  return o;
}

/// A sheet between two boxes that close on it until they overlap by 3 cm, and open again.
Scene press(Precision precision) {
  Scene s;
  s.precision = precision;
  s.materials.push_back(test::cotton());
  s.contact.thickness = 0.004;
  s.contact.compliance_distance = std::numeric_limits<double>::infinity();
  s.solver.partial_rows = 8;
  s.time.step = 0.01;
  // With 12 cells a side it crumples so that zones take many rounds.
  s.cloths.push_back(test::sheet(12, 0));
  s.obstacles.push_back(box("below", -0.07, -0.035));
  s.obstacles.push_back(box("above", 0.07, 0.035));
  return s;
}

/// The frame as the start of another run, which must not be intersecting.
void expect_untangled(const Scene& scene, const Frame& frame) {
  Scene now = scene;
  for (std::size_t c = 0; c < now.cloths.size(); ++c)
    now.cloths[c].mesh.positions = frame.cloth_positions[c];
  for (std::size_t o = 0; o < now.obstacles.size(); ++o) {
    now.obstacles[o].mesh.positions = frame.simulated_obstacle(o);
    now.obstacles[o].motion.clear();
  }
  EXPECT_NO_THROW(refuse_intersecting_start(now)) << "frame " << frame.number;
}

TEST(Pinch, ObstaclesYieldToTheClothBetweenThemAndGoOn) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const Scene s = press(precision);
    Simulation one(s, host_devices(1));
    Simulation two(s, host_devices(2));
    int compliant = 0;
    double distance = 0;
    StepReport last;
    for (int n = 0; n < 80; ++n) {
      last = one.step();
      ASSERT_EQ(Failure::none, last.failure) << last.failure_detail << " at " << last.time;
      ASSERT_EQ(Failure::none, two.step().failure);
      compliant = std::max(compliant, last.compliant);
      distance = std::max(distance, last.compliance_distance);
      if (n % 8 == 7) expect_untangled(s, one.frame());
    }
    EXPECT_GT(compliant, 20);
    // Either box gives way by half of what they overlap, and by what keeps cloth between them.
    EXPECT_GT(distance, 0.01);
    EXPECT_LT(distance, 0.03);
    // Once they have parted everything is where it should be.
    EXPECT_EQ(0, last.compliant);
    const Frame frame = one.frame();
    for (std::size_t v = 0; v < s.obstacles[0].mesh.positions.size(); ++v)
      EXPECT_NEAR(s.obstacles[0].mesh.positions[v][2] - 0.07, frame.obstacle_positions[0][v][2],
                  1e-6);
    EXPECT_EQ(one.state_hash(), two.state_hash());
  }
}

TEST(Pinch, FramesHaveObstaclesWhereTheSceneAndWhereTheStepPutsThem) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    Scene s = press(precision);
    s.cloths = {test::sheet(6, 0)};
    s.obstacles.push_back(box("apart", 1, 1));
    Simulation simulation(s, host_devices(1));
    for (int n = 0; n < 32; ++n) {
      ASSERT_EQ(Failure::none, simulation.step().failure);
      EXPECT_TRUE(n >= 4 || !simulation.frame().any_displaced()) << n;
    }
    const Frame frame = simulation.frame();
    ASSERT_TRUE(frame.any_displaced());
    EXPECT_TRUE(frame.displaced_obstacle_positions[2].empty());
    EXPECT_EQ(&frame.simulated_obstacle(2), &frame.obstacle_positions[2]);
    for (std::size_t o = 0; o < 2; ++o) {
      const Transform place = transform_at(s.obstacles[o].motion, frame.time);
      ASSERT_EQ(frame.obstacle_positions[o].size(), frame.displaced_obstacle_positions[o].size());
      double farthest = 0;
      for (std::size_t v = 0; v < frame.obstacle_positions[o].size(); ++v) {
        const Vec3<double> prescribed = apply(place, s.obstacles[o].mesh.positions[v]);
        const Vec3<double>& x = frame.obstacle_positions[o][v];
        EXPECT_EQ(precision == Precision::single_precision
                      ? vec_cast<double>(vec_cast<float>(prescribed))
                      : prescribed,
                  x);
        farthest = std::max(farthest, length(frame.displaced_obstacle_positions[o][v] - x));
      }
      EXPECT_GT(farthest, 0.001);
    }
  }
}

/// Both boxes would have to jump by more than two thicknesses: in half the time by less each time.
TEST(Pinch, WhatWouldYieldFarAtOnceDoesSoInShorterSteps) {
  Scene s = press(Precision::double_precision);
  for (Obstacle& o : s.obstacles) {
    const double side = o.name == "below" ? -1 : 1;
    o.motion = {{0, {{0, 0, 0.055 * side}}},
                {0.02, {{0, 0, 0.055 * side}}},
                {0.03, {{0, 0, 0.035 * side}}}};
  }
  s.solver.newton_iterations = 1;  // so that zones, not Newton's method, have to give up
  Simulation simulation(s, host_devices(1));
  for (int n = 0; n < 2; ++n) EXPECT_EQ(0, simulation.step().compliant);
  const StepReport closed = simulation.step();
  EXPECT_EQ(Failure::none, closed.failure) << closed.failure_detail;
  EXPECT_GT(closed.compliance_distance, 3 * contact_thickness(s.contact));
  EXPECT_GT(closed.retries, 0);
  EXPECT_GE(closed.fallback_level, FallbackLevel::halved);
  expect_untangled(s, simulation.frame());
  // Where they are they may stay.
  const StepReport after = simulation.step();
  EXPECT_GT(after.compliance_distance, 3 * contact_thickness(s.contact));
  EXPECT_EQ(0, after.retries);
}

/// The last report of a run that has to fail before the boxes have met.
StepReport run_until_failure(const Scene& scene, Simulation& simulation) {
  StepReport last;
  for (int n = 0; n < 40 && last.failure == Failure::none; ++n) last = simulation.step();
  // It stands where it was still possible, and goes no further when asked again.
  expect_untangled(scene, simulation.frame());
  EXPECT_NE(Failure::none, simulation.step().failure);
  return last;
}

TEST(Pinch, ARunWhoseObstaclesMayNotYieldEndsWithANamedFailure) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    Scene s = press(precision);
    s.contact.compliance_distance = 0;
    Simulation simulation(s, host_devices(2));
    const StepReport last = run_until_failure(s, simulation);
    EXPECT_EQ(Failure::pinched, last.failure) << last.failure_detail;
    EXPECT_NE(std::string::npos, last.failure_detail.find("above")) << last.failure_detail;
    EXPECT_EQ(FallbackLevel::failed, last.fallback_level);
    ASSERT_TRUE(last.failure_place);
    // Where cloth is between the boxes.
    EXPECT_LE(std::abs((*last.failure_place)[0]), 0.11);
    EXPECT_LE(std::abs((*last.failure_place)[1]), 0.11);
    EXPECT_LE(std::abs((*last.failure_place)[2]), 0.02);
    EXPECT_EQ(0, last.compliant);
    EXPECT_GT(last.retries, 0);
    EXPECT_GT(last.zones_unsolved, 0);
    const int attempts = last.retries + (1 << s.contact.substep_bisections);
    EXPECT_LE(last.zone_rounds, attempts * s.contact.zone_rounds);
    // The boxes meet at 0.27 s; cloth has a place almost until then.
    EXPECT_GT(simulation.time(), 0.15);
    EXPECT_LT(simulation.time(), 0.3);
  }
}

TEST(Pinch, ObstaclesThatWouldYieldTooFarEndTheRun) {
  Scene s = press(Precision::single_precision);
  s.contact.compliance_distance = 0.004;
  Simulation simulation(s, host_devices(1));
  const StepReport last = run_until_failure(s, simulation);
  EXPECT_EQ(Failure::pinched, last.failure) << last.failure_detail;
  EXPECT_NE(std::string::npos, last.failure_detail.find("contact.compliance_distance allows 0.004"))
      << last.failure_detail;
  EXPECT_GT(last.compliance_distance, 0.004);
  EXPECT_EQ(FallbackLevel::failed, last.fallback_level);
}

/// A patch of cloth of side `size` and n x n cells around `centre`.
Cloth patch(const char* name, double size, int n, const Vec3<double>& centre) {
  Cloth c;
  c.name = name;
  c.mesh = make_grid({size, size}, {n, n}, Diagonals::alternating);
  for (auto& x : c.mesh.positions) x += centre;
  return c;
}

/// What rests has boxes without a margin, which it leaves when it yields: a plate of few triangles
/// is struck in its middle, and within that step its slopes come down on a patch beside, which was
/// too far away to be paired with them. The cloth in between keeps to its boxes meanwhile: it has
/// been thrown at the plate a step before, and large changes of velocity get large boxes.
TEST(Pinch, ObstaclesAtRestThatYieldAreSearchedAnew) {
  Scene s = press(Precision::single_precision);
  s.gravity = {0, 0, 0};
  s.contact.thickness = 0.001;
  s.cloths = {patch("struck", 0.02, 4, {0, 0, 0.012}),
              patch("beside", 0.06, 16, {0.08, 0, -0.0025})};
  s.obstacles[0].mesh = make_grid({0.3, 0.3}, {2, 2}, Diagonals::same);
  s.obstacles[0].mesh.material.clear();
  s.obstacles[0].motion.clear();
  s.obstacles[1].mesh = make_icosphere(0.03, 3);
  s.obstacles[1].motion = {{0, {{0, 0, 0.0435}}}, {0.02, {{0, 0, 0.0235}}}};
  Simulation simulation(s, host_devices(1));
  int compliant = 0;
  for (int n = 0; n < 4; ++n) {
    const StepReport r = simulation.step();
    ASSERT_EQ(Failure::none, r.failure) << r.failure_detail << " at " << r.time;
    compliant = std::max(compliant, r.compliant);
    expect_untangled(s, simulation.frame());
  }
  EXPECT_GT(compliant, 5);
}

TEST(Pinch, NothingYieldsToClothThatLiesOnOneObstacle) {
  Simulation simulation(test::sheet_on_sphere(Precision::single_precision), host_devices(1));
  for (int n = 0; n < 60; ++n) {
    const StepReport r = simulation.step();
    ASSERT_EQ(Failure::none, r.failure);
    EXPECT_EQ(0, r.compliant);
  }
}

}  // namespace
}  // namespace weft
