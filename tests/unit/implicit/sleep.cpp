// Cloth at rest is left out of the steps, within a bound, and wakes in time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "host/exec/host_devices.hpp"
#include "host/model/model_part.hpp"
#include "host/scene/intersection_check.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double bound = 1e-3;  // [m]

/// A sheet that lies on a floor, and another one, two metres away, that swings from two corners.
Scene resting_and_swinging(Precision precision) {
  Scene s;
  s.name = "resting and swinging";
  s.precision = precision;
  s.materials.push_back(test::cotton());
  s.materials[0].damping_stiffness = 5e-3;
  s.contact.thickness = 0.002;
  s.solver.partial_rows = 8;
  s.time.step = 0.01;
  s.time.frames = 30;
  // What swings shakes what rests by as much as the solver leaves over of it.
  s.solver.tolerance = 1e-5;
  s.cloths.push_back(test::sheet(6, 0.0021));
  s.cloths.push_back(test::sheet(5, 0.6));
  for (auto& p : s.cloths[1].mesh.positions) p[0] += 2;
  Pin pin;
  pin.cloth = 1;
  pin.vertices = {0, 5};
  s.pins = {pin};
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = make_box({0.8, 0.8, 0.1}, {2, 2, 1});
  floor.transform.translate = {0.2, 0.2, -0.05};
  s.obstacles.push_back(floor);
  s.implicit.sleep_distance = bound;
  s.implicit.sleep_window = 0.05;
  return s;
}

/// A ball that comes in over the floor from 0.5 s on and pushes the sheet along.
Scene with_ball(Scene s) {
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.05, 2);
  ball.friction = 2;
  const Transform away{{-0.6, 0.2, 0.06}}, there{{0.1, 0.2, 0.053}};
  ball.motion = {{0, away}, {0.5, away}, {0.9, there}};
  s.obstacles.push_back(ball);
  return s;
}

struct Ran {
  Frame frame;
  std::uint64_t hash = 0;
  SleepReport sums;         ///< departure: the largest
  std::int64_t asleep = 0;  ///< vertices in the last step
};

Ran advance(Simulation& simulation, int steps) {
  Ran ran;
  for (int k = 0; k < steps; ++k) {
    const StepReport r = simulation.step();
    EXPECT_EQ(Failure::none, r.failure) << r.failure_detail;
    ran.sums.fell_asleep += r.sleep.fell_asleep;
    ran.sums.woken += r.sleep.woken;
    ran.sums.redone += r.sleep.redone;
    ran.sums.asleep += r.sleep.asleep;
    ran.sums.departure = std::max(ran.sums.departure, r.sleep.departure);
    ran.asleep = r.sleep.asleep;
  }
  ran.frame = simulation.frame();
  ran.hash = simulation.state_hash();
  return ran;
}

Ran run(const Scene& scene, int steps, int ranks = 1) {
  Simulation simulation(scene, host_devices(ranks, {true, 0}));
  return advance(simulation, steps);
}

double farthest(const std::vector<Vec3<double>>& a, const std::vector<Vec3<double>>& b) {
  double most = 0;
  for (std::size_t v = 0; v < a.size(); ++v) most = std::max(most, length(a[v] - b[v]));
  return most;
}

/// Throws if anything intersects.
void look_for_intersections(Scene scene, const Frame& frame) {
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    scene.cloths[c].mesh.positions = frame.cloth_positions[c];
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    scene.obstacles[o].mesh.positions = frame.simulated_obstacle(o);
    scene.obstacles[o].motion.clear();
    scene.obstacles[o].transform = {};
  }
  refuse_intersecting_start(scene, {});
}

TEST(Sleep, WhatRestsBesideAMovingSheetDepartsByLessThanTheBound) {
  Scene s = resting_and_swinging(Precision::double_precision);
  s.solver.tolerance = 1e-9;
  const Ran asleep = run(s, 120);
  EXPECT_EQ(1, asleep.sums.fell_asleep);
  EXPECT_EQ(0, asleep.sums.woken);
  EXPECT_EQ(49, asleep.asleep);
  EXPECT_GT(asleep.sums.asleep, 49 * 80);
  EXPECT_GT(asleep.sums.departure, 0);
  EXPECT_LE(asleep.sums.departure, bound);
  s.implicit.sleep_distance = 0;
  const Ran awake = run(s, 120);
  EXPECT_EQ(0, awake.sums.asleep);
  const double departure =
      farthest(asleep.frame.cloth_positions[0], awake.frame.cloth_positions[0]);
  EXPECT_GT(departure, 0);
  EXPECT_LE(departure, asleep.sums.departure);
  // What is awake is solved by itself: the same motion to the solver's tolerance.
  EXPECT_LE(farthest(asleep.frame.cloth_positions[1], awake.frame.cloth_positions[1]), 1e-6);
}

TEST(Sleep, NothingSleepsThatMayNotOrThatMoves) {
  Scene s = resting_and_swinging(Precision::single_precision);
  s.implicit.sleep_distance = 1e-9;
  EXPECT_EQ(0, run(s, 60).sums.asleep);
  s = resting_and_swinging(Precision::single_precision);
  s.obstacles.clear();  // both fall, or swing
  EXPECT_EQ(0, run(s, 60).sums.asleep);
}

TEST(Sleep, WhatAProgramChangesWakes) {
  Scene s = resting_and_swinging(Precision::single_precision);
  s.cloths.pop_back();
  Pin pin;
  pin.vertices = {0, 6, 42, 48};
  s.pins = {pin};
  const auto height = [](const Frame& frame) {
    double sum = 0;
    for (const Vec3<double>& x : frame.cloth_positions[0]) sum += x[2];
    return sum / 49;
  };
  // A sheet that lies on the floor begins to rise; with the pins, only its middle does.
  Simulation raised(s, host_devices(1));
  ASSERT_EQ(advance(raised, 120).asleep, 49);
  const double before = height(raised.frame());
  raised.set_gravity({0, 0, 3});
  EXPECT_EQ(advance(raised, 20).asleep, 0);
  const double held = height(raised.frame());
  EXPECT_GT(held, before + 0.01);
  // Let go, it flies.
  Simulation released(s, host_devices(1));
  ASSERT_EQ(advance(released, 120).asleep, 49);
  released.release({0, released.scene().identity.number()});
  EXPECT_EQ(advance(released, 1).asleep, 0);
  // A wind that blows already, from elsewhere.
  s.wind = {1.2, {0, 0, -0.5}, 0};
  Simulation blown(s, host_devices(1));
  ASSERT_EQ(advance(blown, 120).asleep, 49);
  blown.set_wind({1.2, {0, 0, 12}, 0});
  EXPECT_EQ(advance(blown, 1).asleep, 0);
}

TEST(Sleep, ABallThatRollsInWakes) {
  const Scene s = with_ball(resting_and_swinging(Precision::double_precision));
  Simulation simulation(s, host_devices(1));
  const Ran before = advance(simulation, 60);
  EXPECT_EQ(49, before.asleep);
  const Ran after = advance(simulation, 45);
  EXPECT_EQ(1, after.sums.woken);
  EXPECT_GT(farthest(before.frame.cloth_positions[0], after.frame.cloth_positions[0]), 0.002);
  look_for_intersections(s, after.frame);
}

TEST(Sleep, ASheetThatFallsOnASleeperWakesItInTime) {
  Scene s = resting_and_swinging(Precision::single_precision);
  s.cloths.push_back(test::sheet(4, 0.5));
  for (auto& p : s.cloths[2].mesh.positions) p = {p[0], p[1], p[2] + 0.2 * p[0]};
  Pin pin;
  pin.cloth = 2;
  for (Index v = 0; v < 25; ++v) pin.vertices.push_back(v);
  pin.release_time = 0.6;
  s.pins.push_back(pin);
  Simulation simulation(s, host_devices(1));
  // The pinned sheet sleeps as well, and wakes as its pins let go.
  EXPECT_EQ(49 + 25, advance(simulation, 59).asleep);
  Ran later;
  for (int k = 0; k < 8; ++k) {
    later = advance(simulation, 8);
    look_for_intersections(s, later.frame);
  }
  EXPECT_LT(later.frame.cloth_positions[2][12][2], 0.1);
  EXPECT_GT(later.frame.cloth_positions[2][12][2], 0.003);
}

/// Springs pull a sheet down so hard that a prediction that knows nothing of them is far off.
TEST(Sleep, AStepThatComesNearASleeperIsDoneAgain) {
  Scene s = resting_and_swinging(Precision::double_precision);
  s.time.step = 0.02;
  s.cloths.push_back(test::sheet(4, 0.16));
  Handle handle;
  handle.cloth = 2;
  for (Index v = 0; v < 25; ++v) handle.vertices.push_back(v);
  handle.stiffness = 1e4;
  handle.motion = {{0, {}}, {0.78, {}}, {0.8, {}}, {0.82, {{0, 0, -0.155}}}};
  s.handles = {handle};
  Simulation simulation(s, host_devices(1));
  EXPECT_EQ(49 + 25, advance(simulation, 40).asleep);
  const ScratchFolder folder;
  simulation.save(folder.path() / "before");
  const StepReport report = simulation.step();
  EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
  EXPECT_EQ(2, report.sleep.woken);
  EXPECT_EQ(1, report.sleep.redone);
  // Both passes count: this is what the second one alone takes.
  s.implicit.sleep_distance = 0;
  Simulation awake(s, host_devices(1));
  awake.resume(folder.path() / "before", SceneChanges::allow);
  const StepReport second = awake.step();
  EXPECT_GT(report.solves, second.solves);
  EXPECT_GT(report.iterations, second.iterations);
  EXPECT_GT(report.searches, second.searches);
  EXPECT_EQ(second.fallback_level, report.fallback_level);
  look_for_intersections(s, simulation.frame());
  look_for_intersections(s, advance(simulation, 20).frame);
}

void expect_resumes(const Scene& s) {
  const ScratchFolder folder;
  Simulation first(s, host_devices(1));
  // Within windows: awake, asleep, and woken by the ball.
  for (const int steps : {13, 63, 82}) {
    advance(first, steps - static_cast<int>(first.step_number()));
    const auto file = folder.path() / ("at_" + std::to_string(steps));
    first.save(file);
    Simulation second(s, host_devices(1));
    second.resume(file);
    EXPECT_EQ(first.state_hash(), second.state_hash());
    const Ran resumed = advance(second, 20);
    Simulation straight(s, host_devices(1));
    const Ran whole = advance(straight, steps + 20);
    EXPECT_EQ(whole.hash, resumed.hash) << steps;
    EXPECT_GE(whole.sums.fell_asleep, steps > 60 ? 1 : 0);
  }
}

TEST(Sleep, ResumesBitForBit) {
  expect_resumes(with_ball(resting_and_swinging(Precision::single_precision)));
}

TEST(Sleep, ResumesBitForBitWithHingesAndBdf2) {
  Scene s = with_ball(resting_and_swinging(Precision::double_precision));
  s.integrator = Integrator::bdf2;
  s.bending = Bending::hinge;
  expect_resumes(s);
}

TEST(Sleep, TheSameBitsOnAnyNumberOfRanks) {
  const Scene s = with_ball(resting_and_swinging(Precision::single_precision));
  const Ran one = run(s, 86);
  EXPECT_GE(one.sums.fell_asleep, 1);
  EXPECT_GE(one.sums.woken, 1);
  for (const int ranks : {2, 3, 5}) EXPECT_EQ(one.hash, run(s, 86, ranks).hash) << ranks;
}

TEST(Sleep, AnotherGravityWakes) {
  const ScratchFolder folder;
  Scene s = resting_and_swinging(Precision::single_precision);
  Simulation first(s, host_devices(1));
  EXPECT_EQ(49, advance(first, 60).asleep);
  first.save(folder.path() / "asleep");
  s.gravity = {0, 0, 9.81};
  Simulation second(s, host_devices(1));
  second.resume(folder.path() / "asleep", SceneChanges::allow);
  const Ran lifted = advance(second, 30);
  EXPECT_EQ(0, lifted.asleep);
  EXPECT_GT(lifted.frame.cloth_positions[0][24][2], 0.2);
}

TEST(Sleep, APartOfAModelIsTheModelOfThatPart) {
  const Scene s = resting_and_swinging(Precision::double_precision);
  const Model whole = make_model(s);
  const std::vector<Index> piece = cloth_components(whole);
  std::vector<unsigned char> kept;
  for (const Index p : piece) kept.push_back(p == piece[0] ? 0 : 1);
  const ModelPart part = part_of(whole, kept);
  // That of a scene without the other cloth has the same numbers in another order.
  Scene alone = s;
  const Index left = whole.cloth_of_vertex[at(part.vertex[0])];
  alone.cloths = {s.cloths[at(left)]};
  alone.pins.clear();
  const Model made = make_model(alone);
  EXPECT_EQ(made.cloth_vertex_count, part.model.cloth_vertex_count);
  // What is small is so against the whole.
  EXPECT_EQ(whole.cloth_vertex_count, part.model.whole.vertices);
  EXPECT_EQ(whole.whole.area, part.model.whole.area);
  EXPECT_EQ(whole.whole.mass_2_norm, part.model.whole.mass_2_norm);
  EXPECT_LT(made.whole.area, whole.whole.area);
  EXPECT_LT(made.whole.mass_2_norm, whole.whole.mass_2_norm);
  EXPECT_EQ(made.vertex_count, part.model.vertex_count);
  EXPECT_EQ(made.edges.size(), part.model.edges.size());
  EXPECT_EQ(made.cloth_edge_count, part.model.cloth_edge_count);
  EXPECT_EQ(made.triangles.size(), part.model.triangles.size());
  EXPECT_EQ(made.rest_corners.size(), part.model.rest_corners.size());
  for (std::size_t e = 0; e < part.edge.size(); ++e)
    for (int k = 0; k < 2; ++k)
      EXPECT_EQ(whole.edges[at(part.edge[e])].v[k], part.vertex[at(part.model.edges[e].v[k])]);
  for (std::size_t t = 0; t < part.triangle.size(); ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(whole.triangles[at(part.triangle[t])].v[k],
                part.vertex[at(part.model.triangles[t].v[k])]);
}

}  // namespace
}  // namespace weft
