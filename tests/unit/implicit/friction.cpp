#include <gtest/gtest.h>

#include <cmath>

#include "host/base/scratch_folder.hpp"
#include "host/geometry/procedural.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double gravity = 9.81;

/// A sheet of 0.1 m just above a plate of 64 x 32 triangles, which falls towards +x.
Scene sheet_on_plate(double friction, double slope, Precision precision) {
  Scene s;
  s.precision = precision;
  s.materials.push_back(test::cotton());
  Cloth cloth;
  cloth.name = "sheet";
  cloth.mesh = make_grid({0.1, 0.1}, {6, 6}, Diagonals::alternating);
  for (auto& x : cloth.mesh.positions) x[2] = 0.0999e-2;
  s.cloths.push_back(cloth);
  Obstacle plate;
  plate.name = "plate";
  plate.mesh = make_grid({0.8, 0.4}, {32, 16}, Diagonals::same);
  plate.friction = friction;
  s.obstacles.push_back(plate);
  s.contact.thickness = 1e-3;
  s.solver.tolerance = precision == Precision::double_precision ? 1e-7 : 1e-3;
  s.time.step = 0.0025;
  s.time.frame_rate = 100;
  s.time.frames = 1000;
  const double along = 1 / std::sqrt(1 + slope * slope);
  s.gravity = {gravity * slope * along, 0, -gravity * along};
  return s;
}

/// Mean place and velocity along x.
Vec2<double> progress(const Simulation& simulation) {
  const Frame frame = simulation.frame();
  Vec2<double> sum{0, 0};
  for (std::size_t v = 0; v < frame.cloth_positions[0].size(); ++v)
    sum += {frame.cloth_positions[0][v][0], frame.cloth_velocities[0][v][0]};
  return (1.0 / static_cast<double>(frame.cloth_positions[0].size())) * sum;
}

void advance(Simulation& simulation, int steps) {
  for (int n = 0; n < steps; ++n) {
    const StepReport r = simulation.step();
    ASSERT_EQ(Failure::none, r.failure) << r.failure_detail;
  }
}

TEST(Friction, ClothBelowTheLimitStaysWhereItIs) {
  Simulation simulation(sheet_on_plate(0.52, 0.5, Precision::double_precision), host_devices(1));
  advance(simulation, 200);
  const double before = progress(simulation)[0];
  advance(simulation, 100);
  EXPECT_NEAR(progress(simulation)[0], before, 1e-12);
}

TEST(Friction, ClothAboveTheLimitSlidesAsCoulombSays) {
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    const Scene scene = sheet_on_plate(0.3, 0.5, precision);
    Simulation simulation(scene, host_devices(1));
    advance(simulation, 20);
    const double before = progress(simulation)[1];
    advance(simulation, 80);
    const double acceleration = (progress(simulation)[1] - before) / (80 * 0.0025);
    EXPECT_NEAR(acceleration / (scene.gravity[0] + 0.3 * scene.gravity[2]), 1, 0.01);
  }
}

/// The plate has an edge every 2.5 cm and the sheet crosses dozens of them: nothing but friction
/// may hold it back, and nothing may lift it.
TEST(Friction, EdgesWithinAFlatFloorAreNoObstacle) {
  Scene scene = sheet_on_plate(0, 0, Precision::double_precision);
  scene.cloths[0].velocity = {1, 0, 0};
  Simulation simulation(scene, host_devices(1));
  advance(simulation, 100);
  EXPECT_NEAR(progress(simulation)[1], 1, 1e-4);
  const Frame frame = simulation.frame();
  for (const auto& v : frame.cloth_velocities[0]) EXPECT_NEAR(v[2], 0, 5e-3);
}

TEST(Friction, EachPairOfFeaturesIsOneContact) {
  Scene scene = sheet_on_plate(0.3, 0, Precision::double_precision);
  // Exactly above the plate's vertices and edges.
  scene.cloths[0].mesh = make_grid({0.1, 0.1}, {4, 4}, Diagonals::same);
  for (auto& x : scene.cloths[0].mesh.positions) x[2] = 0.9e-3;
  Simulation simulation(scene, host_devices(1));
  const StepReport r = simulation.step();
  EXPECT_EQ(r.proximities, 25);
}

/// A plate that is shaken by less than friction can hold takes the sheet along.
TEST(Friction, ClothSticksToWhatMoves) {
  Scene scene = sheet_on_plate(0.5, 0, Precision::double_precision);
  Motion& motion = scene.obstacles[0].motion;
  for (int k = 0; k <= 20; ++k) motion.push_back({0.1 * k, {{k % 2 == 0 ? 0.0 : 0.004, 0, 0}}});
  Simulation simulation(scene, host_devices(1));
  advance(simulation, 80);
  const double apart = progress(simulation)[0] - simulation.frame().obstacle_positions[0][0][0];
  advance(simulation, 400);
  EXPECT_NEAR(progress(simulation)[0] - simulation.frame().obstacle_positions[0][0][0], apart,
              2e-5);
}

TEST(Friction, AnchorsAreSavedAndHashed) {
  const Scene scene = sheet_on_plate(0.52, 0.5, Precision::single_precision);
  const ScratchFolder folder;
  const auto file = folder / "anchors.weft";
  Simulation whole(scene, host_devices(2));
  advance(whole, 100);
  whole.save(file);
  Simulation resumed(scene, host_devices(1));
  EXPECT_NE(resumed.state_hash(), whole.state_hash());
  resumed.resume(file);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
  advance(whole, 20);
  advance(resumed, 20);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
}

}  // namespace
}  // namespace weft
