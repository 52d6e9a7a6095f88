// Layers that lie on each other, with default settings, at several steps: heights, gaps, friction
// from below, and a riffle of cards.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "host/lab/check/validator.hpp"
#include "host/scene/suitable_precision.hpp"
#include "tests/physics/measured.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft::physics {
namespace {

constexpr double gravity = 9.81;     // [m/s^2]
constexpr double thickness = 0.001;  // [m] default of contact

struct Case {
  double step;  ///< [s]
  int layers = 0;
  Known known = Known::holds;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << "step " << c.step << " s, layers " << c.layers;
}

std::string name_of(const testing::TestParamInfo<Case>& info) {
  return "step" + std::to_string(std::lround(1e6 * info.param.step)) + "us_layers" +
         std::to_string(info.param.layers);
}

/// Square sheets of the default material above a floor, each at the distance of contact.
Scene stack(int layers, double side, int cells, double step) {
  Scene scene;
  scene.time.step = step;
  scene.materials.push_back({});
  for (int k = 0; k < layers; ++k) {
    Cloth cloth;
    cloth.name = "sheet_" + std::to_string(k);
    cloth.mesh = make_grid({side, side}, {cells, cells}, Diagonals::alternating);
    for (auto& x : cloth.mesh.positions) x[2] = thickness * (k + 1);
    scene.cloths.push_back(cloth);
  }
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = make_grid({4, 2}, {4, 2}, Diagonals::same);
  scene.obstacles.push_back(floor);
  scene.precision = suitable_precision(scene);
  return scene;
}

void step_once(Simulation& simulation) {
  const StepReport report = simulation.step();
  ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
}

Mesh joined(const std::vector<Mesh>& meshes, const std::vector<std::vector<Vec3<double>>>& places) {
  Mesh all;
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const auto first = static_cast<Index>(all.positions.size());
    all.positions.insert(all.positions.end(), places[k].begin(), places[k].end());
    for (const Tri& t : meshes[k].triangles)
      all.triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
  }
  return all;
}

/// Pairs of triangles that meet, cloth with cloth or with an obstacle.
std::int64_t intersections(const Simulation& simulation) {
  std::vector<Mesh> cloths, obstacles;
  for (const Cloth& c : simulation.scene().cloths) cloths.push_back(c.mesh);
  for (const Obstacle& o : simulation.scene().obstacles) obstacles.push_back(o.mesh);
  const Frame frame = simulation.frame();
  const Mesh obstacle = joined(obstacles, frame.obstacle_positions);
  const lab::FrameVerdict verdict = lab::validate(joined(cloths, frame.cloth_positions), &obstacle);
  return verdict.cloth_cloth_count + verdict.cloth_obstacle_count;
}

/// Smallest distance of a vertex from the one below it, or from the floor.
/// @pre all cloths have the same mesh
double least_gap(const Frame& frame) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < frame.cloth_positions.size(); ++k)
    for (std::size_t v = 0; v < frame.cloth_positions[k].size(); ++v) {
      const double below = k == 0 ? 0 : frame.cloth_positions[k - 1][v][2];
      least = std::min(least, frame.cloth_positions[k][v][2] - below);
    }
  return least;
}

double mean_height(const std::vector<Vec3<double>>& x) {
  double sum = 0;
  for (const auto& place : x) sum += place[2];
  return sum / static_cast<double>(x.size());
}

/// Heights, gaps and speeds at every step from 0.8 to 1 s.
void check_stack(const Case& c) {
  Simulation simulation(stack(c.layers, 0.1, 4, c.step), host_devices(1));
  double off = 0;
  double least = std::numeric_limits<double>::infinity();
  double fastest = 0;
  while (simulation.time() < 1 - 1e-9) {
    ASSERT_NO_FATAL_FAILURE(step_once(simulation));
    if (simulation.time() < 0.8) continue;
    const Frame frame = simulation.frame();
    const double height = mean_height(frame.cloth_positions.back());
    off = std::max(off, std::abs(height / (thickness * c.layers) - 1));
    least = std::min(least, least_gap(frame));
    for (const auto& cloth : frame.cloth_velocities)
      for (const auto& v : cloth) fastest = std::max(fastest, length(v));
  }
  expect_at_most("largest speed in m/s", fastest, 1e-3, c.known);
  expect_at_most("error of the height", off, 0.05, c.known);
  expect_at_most("lost of the thickness", 1 - least / thickness, 0.5, c.known);
}

class StackAtRest : public testing::TestWithParam<Case> {};
class SlowStackAtRest : public testing::TestWithParam<Case> {};

TEST_P(StackAtRest, IsAsHighAsItsLayersAreThick) {
  check_stack(GetParam());
}

TEST_P(SlowStackAtRest, IsAsHighAsItsLayersAreThick) {
  check_stack(GetParam());
}

class HeavyPlate : public testing::TestWithParam<Case> {};

/// A plate of thirty times the density of the linen below it.
TEST_P(HeavyPlate, LeavesHalfOfTheThicknessOnEitherSideOfThinCloth) {
  const Case& c = GetParam();
  Scene scene = stack(c.layers, 0.1, 6, c.step);
  scene.materials[0].density = 0.15;
  scene.materials[0].stretch_stiffness = 2000;
  Material plate = scene.materials[0];
  plate.density = 30 * plate.density;
  plate.stretch_stiffness = 2e4;
  plate.bending_stiffness = 0.05;
  scene.materials.push_back(plate);
  scene.cloths[1].material = 1;
  scene.precision = suitable_precision(scene);
  Simulation simulation(scene, host_devices(1));
  double least = std::numeric_limits<double>::infinity();
  while (simulation.time() < 1 - 1e-9) {
    ASSERT_NO_FATAL_FAILURE(step_once(simulation));
    if (simulation.time() > 0.4) least = std::min(least, least_gap(simulation.frame()));
  }
  expect_at_most("lost of the thickness", 1 - least / thickness, 0.5, c.known);
}

class PulledStack : public testing::TestWithParam<Case> {
 protected:
  /// @param seed    of the start
  /// @param most    out: largest acceleration of a sheet over 0.05 s, over that of friction
  /// @param fastest out: largest velocity of a sheet [m/s]
  void pull(int seed, double& most, double& fastest) const;
};

void PulledStack::pull(int seed, double& most, double& fastest) const {
  const Case& c = GetParam();
  Scene scene = stack(c.layers, 0.2, 8, c.step);
  std::mt19937 random(static_cast<unsigned>(seed));
  for (Cloth& cloth : scene.cloths)
    for (auto& x : cloth.mesh.positions)
      x[0] += 1e-6 * (static_cast<double>(random()) / 4294967296.0 - 0.5);
  Pin pin;
  for (std::size_t v = 0; v < scene.cloths[0].mesh.positions.size(); ++v)
    if (scene.cloths[0].mesh.positions[v][0] > 0.0999)
      pin.vertices.push_back(static_cast<Index>(v));
  constexpr double start = 0.2;
  pin.motion = {{0, {}}, {start, {}}};
  for (int k = 1; k <= 25; ++k) pin.motion.push_back({start + 0.02 * k, {{0.02 * k, 0, 0}}});
  scene.pins.push_back(pin);
  Simulation simulation(scene, host_devices(1));
  const auto upper = static_cast<std::size_t>(c.layers) - 1;
  std::vector<std::vector<double>> velocity(upper);
  std::int64_t met = 0;
  for (double seen = 0; simulation.time() < start + 0.3 - 1e-9;) {
    ASSERT_NO_FATAL_FAILURE(step_once(simulation));
    const Frame frame = simulation.frame();
    for (std::size_t k = 0; k < upper; ++k) {
      double sum = 0;
      for (const auto& v : frame.cloth_velocities[k + 1]) sum += v[0];
      velocity[k].push_back(sum / static_cast<double>(frame.cloth_velocities[k + 1].size()));
    }
    if (simulation.time() < seen + 0.02 - 1e-9) continue;
    seen = simulation.time();
    met += intersections(simulation);
  }
  const auto window = static_cast<std::size_t>(std::ceil(0.05 / c.step - 1e-9));
  most = fastest = 0;
  for (const auto& v : velocity)
    for (std::size_t n = window; n < v.size(); ++n) {
      most = std::max(most, std::abs(v[n] - v[n - window]));
      fastest = std::max(fastest, v[n]);
    }
  most /= static_cast<double>(window) * c.step * scene.contact.friction * gravity;
  EXPECT_EQ(met, 0);
}

/// The lowest of five sheets is pulled away, and friction alone moves the others. At its limit
/// below a sheet it drives that sheet and all above it, so that none gets faster than by mu g. The
/// largest acceleration depends on the last bits of the start: the mean of three counts.
TEST_P(PulledStack, MovesUpperSheetsByNoMoreThanFriction) {
  constexpr int starts = 3;
  double sum = 0;
  for (int seed = 1; seed <= starts; ++seed) {
    double most = 0, fastest = 0;
    ASSERT_NO_FATAL_FAILURE(pull(seed, most, fastest));
    EXPECT_GT(fastest, 0.02 * Scene{}.contact.friction * gravity) << "friction moves nothing";
    sum += most;
  }
  expect_at_most("largest mean acceleration over 0.05 s", sum / starts, 1.05, GetParam().known);
}

/// Sheets that are turned against each other hang down to the table at their corners. Contacts
/// there come and go, and none of them may pull at cloth that hangs above it: for as long as one
/// does, corners drop and rise for ever.
TEST(TurnedStack, ComesToRest) {
  Scene scene = stack(0, 0, 0, 0.005);
  scene.obstacles[0].mesh = make_grid({0.8, 0.8}, {50, 50}, Diagonals::same);
  Material& cotton = scene.materials[0];
  cotton.density = 0.15;
  cotton.stretch_stiffness = 800;
  cotton.bending_stiffness = 1e-5;
  cotton.damping_stiffness = 5e-4;
  for (int k = 0; k < 10; ++k) {
    Cloth cloth;
    cloth.name = "sheet_" + std::to_string(k);
    cloth.mesh = make_grid({0.5, 0.5}, {16, 16}, Diagonals::alternating);
    const double turn = 7 * k * std::numbers::pi / 180, tilt = 2 * std::numbers::pi / 180;
    for (auto& x : cloth.mesh.positions)
      x = {std::cos(turn) * x[0] - std::sin(turn) * std::cos(tilt) * x[1],
           std::sin(turn) * x[0] + std::cos(turn) * std::cos(tilt) * x[1],
           0.03 + 0.01 * k + std::sin(tilt) * x[1]};
    scene.cloths.push_back(cloth);
  }
  Simulation simulation(scene, host_devices(1));
  double most = 0;
  std::int64_t solves = 0;
  for (int step = 0; step < 192; ++step) {
    const StepReport report = simulation.step();
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
    if (step < 152) continue;
    most = std::max(most, simulation.energy().kinetic);
    solves += report.solves;
  }
  expect_at_most("kinetic energy after 0.76 s", most, 2e-9, Known::holds);
  expect_at_most("solves in 40 steps", static_cast<double>(solves), 48, Known::holds);
}

class SlowRiffle : public testing::TestWithParam<Case> {};

/// Two halves of a deck of cards fall into each other, and then lie on the table.
TEST_P(SlowRiffle, GainsNoEnergy) {
  const Case& c = GetParam();
  Scene scene = stack(0, 0, 0, c.step);
  scene.materials[0].density = 0.3;
  scene.materials[0].stretch_stiffness = 9e5;
  scene.materials[0].bending_stiffness = 7e-3;
  for (int k = 0; k < c.layers; ++k) {
    Cloth card;
    card.name = "card_" + std::to_string(k);
    card.mesh = make_grid({0.088, 0.063}, {6, 4}, Diagonals::alternating);
    // The halves overlap by 2 cm.
    const double x = k % 2 == 0 ? -0.034 : 0.034;
    for (auto& place : card.mesh.positions) place += Vec3<double>{x, 0, 0.004 * (k + 1)};
    scene.cloths.push_back(card);
  }
  scene.precision = suitable_precision(scene);
  Simulation simulation(scene, host_devices(1));
  const double start = simulation.energy().gravitational;
  double gain = -std::numeric_limits<double>::infinity();
  std::int64_t met = 0;
  for (double seen = 0; simulation.time() < 0.6 - 1e-9;) {
    ASSERT_NO_FATAL_FAILURE(step_once(simulation));
    const Energy energy = simulation.energy();
    gain = std::max(gain, (energy.kinetic + energy.elastic) / (start - energy.gravitational) - 1);
    if (simulation.time() < seen + 0.02 - 1e-9) continue;
    seen = simulation.time();
    met += intersections(simulation);
  }
  expect_at_most("gain of energy", gain, 0.01, c.known);
  EXPECT_EQ(met, 0);
}

INSTANTIATE_TEST_SUITE_P(Steps, StackAtRest,
                         testing::Values(Case{0.005, 2}, Case{0.005, 5}, Case{0.02, 2}), name_of);

INSTANTIATE_TEST_SUITE_P(Steps, SlowStackAtRest, testing::Values(Case{0.005, 50}, Case{0.02, 50}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Steps, HeavyPlate,
                         testing::Values(Case{0.0025, 2}, Case{0.005, 2}, Case{0.01, 2},
                                         Case{0.02, 2}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Steps, PulledStack,
                         testing::Values(Case{0.0025, 5}, Case{0.005, 5}, Case{0.01, 5},
                                         Case{0.02, 5}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Steps, SlowRiffle,
                         testing::Values(Case{0.002, 54}, Case{0.005, 54}, Case{0.01, 54}),
                         name_of);

}  // namespace
}  // namespace weft::physics
