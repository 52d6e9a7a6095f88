#include <gtest/gtest.h>

#include <cmath>

#include "host/base/scratch_folder.hpp"
#include "host/implicit/step.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/core/ids.hpp"
#include "weft/shapes.hpp"
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

/// A sheet slides on a plate, and another sheet on it. The forces in the contact cache obey
/// Coulomb's law pair by pair, and add up to the change of momentum. The step tolerates an error of
/// friction of a tenth of the weight of a component of cloth.
TEST(Friction, OfEachPairIsWithinItsLimitInEachStep) {
  for (const double h : {0.0025, 0.01, 0.02}) {
    Scene scene = sheet_on_plate(0.3, 0, Precision::double_precision);
    scene.time.step = h;
    scene.contact.friction = 0.5;
    scene.cloths[0].velocity = {1, 0.2, 0};
    scene.cloths.push_back(scene.cloths[0]);
    scene.cloths[1].name = "above";
    for (auto& x : scene.cloths[1].mesh.positions) x += {0.003, 0.004, 0.9e-3};
    DeviceSet devices = host_devices(1);
    Store<double> store(scene, devices);
    ImplicitStep<double> step(store);
    const Model& model = store.model();
    const auto momentum = [&](const StateSnapshot<double>& state) {
      Vec3<double> sum{};
      for (Index v = 0; v < model.cloth_vertex_count; ++v)
        sum += model.mass[at(v)] * state.velocities[at(v)];
      return sum;
    };
    const double weight = gravity * model.whole.mass;
    int slides = 0, between = 0, steps = 0;
    double missed = 0;
    StateSnapshot<double> before = store.snapshot();
    while (before.time < 0.3) {
      StepReport report;
      step.advance(h, report);
      ASSERT_EQ(Failure::none, report.failure);
      const StateSnapshot<double> after = store.snapshot();
      Vec3<double> force{0, 0, -weight};
      for (std::size_t i = 0; i < after.contacts.size(); ++i) {
        const ContactMemory<double>& c = after.contacts[i];
        const bool face = i < at(static_cast<Index>(after.face_contacts));
        const bool plate_first = face && c.pair.a >= model.cloth_vertex_count;
        const bool plate_second =
            c.pair.b >= (face ? model.cloth_triangle_count : model.cloth_edge_count);
        const bool plate = plate_first || plate_second;
        const double limit = (plate ? 0.3 : 0.5) * c.normal_force;
        EXPECT_GE(c.normal_force, 0);
        EXPECT_LE(length(c.friction), limit * (1 + 1e-12));
        EXPECT_NEAR(dot(c.friction, c.n), 0, 1e-12 * limit);
        slides += c.normal_force > 0 && length(c.friction) > 0.999 * limit ? 1 : 0;
        between += c.normal_force > 0 && !plate ? 1 : 0;
        if (plate) force += (plate_first ? -1.0 : 1.0) * (c.normal_force * c.n - c.friction);
      }
      const Vec3<double> change = (momentum(after) - momentum(before)) * (1 / h);
      if (report.retries == 0) {
        ++steps;
        missed += length(change - force) / weight;
        EXPECT_LT(length(change - force), 0.1 * weight) << h << " s, at " << after.time << " s";
      }
      before = after;
    }
    EXPECT_LT(missed / steps, 0.02) << h;
    EXPECT_GT(slides, 500) << h;
    EXPECT_GT(between, 200) << h;
  }
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
