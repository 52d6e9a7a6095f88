// Coulomb's law must not depend on the time step. Sheets on planes, with default settings, against
// closed forms at four steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/suitable_precision.hpp"
#include "tests/physics/measured.hpp"
#include "tests/support/jittered.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft::physics {
namespace {

constexpr double gravity = 9.81;  // [m/s^2]
constexpr double side = 0.2;      // [m] of the sheet

struct Plane {
  double friction;
  double angle = 0;  ///< [rad] falls towards +x
  double cell = 2;   ///< [m] legs of its triangles
};

/// A sheet at the distance of contact above a plane, with the default material and settings.
Scene sheet_on(const Plane& plane, double step) {
  Scene scene;
  scene.time.step = step;
  scene.materials.push_back({});
  const Transform tilt{{0, 0, 0}, {0, 1, 0}, plane.angle, 1};
  Transform above = tilt;
  above.translate = apply(tilt, {0, 0, contact_thickness(scene.contact)});
  Cloth cloth;
  cloth.name = "sheet";
  cloth.mesh = make_grid({side, side}, {8, 8}, Diagonals::alternating);
  for (auto& x : cloth.mesh.positions) x = apply(above, x);
  scene.cloths.push_back(cloth);
  Obstacle obstacle;
  obstacle.name = "plane";
  const auto cells = static_cast<Index>(std::lround(2 / plane.cell));
  obstacle.mesh = make_grid({8, 2}, {4 * cells, cells}, Diagonals::same);
  obstacle.transform = tilt;
  obstacle.friction = plane.friction;
  scene.obstacles.push_back(obstacle);
  scene.precision = suitable_precision(scene);
  return scene;
}

struct Mean {
  Vec3<double> place;     ///< [m]
  Vec3<double> velocity;  ///< [m/s]
};

Mean mean_of(const Simulation& simulation) {
  const Frame frame = simulation.frame();
  const auto& x = frame.cloth_positions[0];
  Mean sum{};
  for (std::size_t v = 0; v < x.size(); ++v) {
    sum.place += x[v];
    sum.velocity += frame.cloth_velocities[0][v];
  }
  const double share = 1 / static_cast<double>(x.size());
  return {share * sum.place, share * sum.velocity};
}

void step_once(Simulation& simulation) {
  const StepReport report = simulation.step();
  ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
}

void advance_to(Simulation& simulation, double time) {
  while (simulation.time() < time - 1e-9) ASSERT_NO_FATAL_FAILURE(step_once(simulation));
}

struct Case {
  double step;  ///< [s]
  Plane plane;
  Known known = Known::holds;
  double speed = 0;  ///< [m/s]
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << "step " << c.step << " s, friction " << c.plane.friction << ", angle " << c.plane.angle
       << ", triangles of " << c.plane.cell << " m, speed " << c.speed << " m/s";
}

/// In microseconds, thousandths, milliradians, millimetres, and millimetres per second.
std::string name_of(const testing::TestParamInfo<Case>& info) {
  const auto thousandths = [](double x) { return std::to_string(std::lround(1e3 * x)); };
  const Case& c = info.param;
  return "step" + thousandths(1e3 * c.step) + "_friction" + thousandths(c.plane.friction) +
         "_angle" + thousandths(c.plane.angle) + "_cell" + thousandths(c.plane.cell) + "_speed" +
         thousandths(c.speed);
}

/// Means over a sheet on an incline after 0.4 and 0.8 s.
auto means_on_incline(const Case& c) {
  Simulation simulation(sheet_on(c.plane, c.step), host_devices(1));
  advance_to(simulation, 0.4);
  const auto first = mean_of(simulation);
  advance_to(simulation, 0.8);
  return std::pair(first, mean_of(simulation));
}

class InclineHolds : public testing::TestWithParam<Case> {};

TEST_P(InclineHolds, ClothBelowTheAngleOfFriction) {
  const Case& c = GetParam();
  const auto [first, second] = means_on_incline(c);
  const double creep = length(second.place - first.place) / 0.4;
  expect_at_most("sizes per second", creep / side, 1e-4, c.known);
}

class InclineSlides : public testing::TestWithParam<Case> {};

TEST_P(InclineSlides, ClothAboveTheAngleOfFriction) {
  const Case& c = GetParam();
  const auto [first, second] = means_on_incline(c);
  const double acceleration = length(second.velocity - first.velocity) / 0.4;
  const double right =
      gravity * (std::sin(c.plane.angle) - c.plane.friction * std::cos(c.plane.angle));
  expect_at_most("error of the acceleration", std::abs(acceleration / right - 1), 0.05, c.known);
}

class Braking : public testing::TestWithParam<Case> {};

/// Implicit Euler stops v h / 2 short of v^2 / (2 mu g): by 4 % in the longest step.
TEST_P(Braking, StopsWhereItShouldAndStays) {
  const Case& c = GetParam();
  Scene scene = sheet_on(c.plane, c.step);
  scene.cloths[0].velocity = {c.speed, 0, 0};
  Simulation simulation(scene, host_devices(1));
  const Vec3<double> start = mean_of(simulation).place;
  const double rate = c.plane.friction * gravity;
  const double stopped = 1.2 * c.speed / rate + 0.1;
  advance_to(simulation, stopped);
  const Vec3<double> end = mean_of(simulation).place;
  advance_to(simulation, stopped + 0.4);
  const double creep = length(mean_of(simulation).place - end) / 0.4;
  const double way = c.speed * c.speed / (2 * rate);
  expect_at_most("error of the way", std::abs((end - start)[0] / way - 1), 0.05, c.known);
  expect_at_most("sizes per second afterwards", creep / side, 1e-4, Known::holds);
}

class Conveyor : public testing::TestWithParam<Case> {};

/// A plane starts to move within 0.02 s. Friction alone drives the sheet, which stays slower than
/// the plane here.
/// @param most [m/s] by which it becomes faster within 0.05 s
void drive(const Case& c, unsigned start_number, double& most) {
  Scene scene = sheet_on(c.plane, c.step);
  constexpr double start = 0.2;
  scene.obstacles[0].motion = {{0, {}}, {start, {}}};
  for (int k = 1; k <= 20; ++k)
    scene.obstacles[0].motion.push_back({start + 0.02 * k, {{c.speed * 0.02 * k, 0, 0}}});
  Simulation simulation(jittered(scene, start_number), host_devices(1));
  advance_to(simulation, start);
  std::vector<double> velocity = {mean_of(simulation).velocity[0]};
  while (simulation.time() < start + 0.35 - 1e-9) {
    ASSERT_NO_FATAL_FAILURE(step_once(simulation));
    velocity.push_back(mean_of(simulation).velocity[0]);
  }
  const auto window = static_cast<std::size_t>(std::ceil(0.05 / c.step - 1e-9));
  for (std::size_t n = window; n < velocity.size(); ++n)
    most = std::max(most, velocity[n] - velocity[n - window]);
  EXPECT_GT(velocity.back(), 0.9 * c.plane.friction * gravity * 0.35)
      << "friction does not drive it";
}

/// From any of some starts: where vertices cross edges of the plane, chaos decides.
TEST_P(Conveyor, DrivesClothByNoMoreThanFriction) {
  const Case& c = GetParam();
  double most = 0;
  for (unsigned start = 0; start < 8; ++start) ASSERT_NO_FATAL_FAILURE(drive(c, start, most));
  const double length = std::ceil(0.05 / c.step - 1e-9) * c.step;
  expect_at_most("largest mean acceleration over 0.05 s",
                 most / (length * c.plane.friction * gravity), 1.1, c.known);
}

class ImpulseOfFriction : public testing::TestWithParam<Case> {};

/// Only gravity, the normal force and friction change the momentum of a sheet on a plane.
TEST_P(ImpulseOfFriction, IsAtMostThatOfTheNormalForceTimesTheCoefficient) {
  const Case& c = GetParam();
  Scene scene = sheet_on(c.plane, c.step);
  scene.precision = Precision::double_precision;
  scene.cloths[0].velocity = {c.speed, 0, 0};
  Simulation simulation(scene, host_devices(1));
  Vec3<double> before = mean_of(simulation).velocity;
  double most = 0;
  while (simulation.time() < 0.3 - 1e-9) {
    ASSERT_NO_FATAL_FAILURE(step_once(simulation));
    const Vec3<double> after = mean_of(simulation).velocity;
    const Vec3<double> change = after - before;
    before = after;
    const double normal = change[2] + gravity * c.step;
    if (normal > 0)
      most = std::max(most, std::hypot(change[0], change[1]) / (c.plane.friction * normal));
  }
  expect_at_most("friction over its limit", most, 1 + 1e-6, c.known);
}

constexpr double steps[] = {0.0025, 0.005, 0.01, 0.02};

/// A case at each of the steps.
std::vector<Case> at_steps(const Plane& plane, double speed, const Known (&known)[4]) {
  std::vector<Case> cases;
  for (int k = 0; k < 4; ++k) cases.push_back({steps[k], plane, known[k], speed});
  return cases;
}

std::vector<Case> operator+(std::vector<Case> a, const std::vector<Case>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

constexpr Known holds = Known::holds;
constexpr Known misses = Known::misses;
const double limit = std::atan(0.5);  // [rad] angle of friction

// At half of the angle of friction the solves of a step take contacts to slide downhill, then
// uphill: they have to stick.
INSTANTIATE_TEST_SUITE_P(
    Steps, InclineHolds,
    testing::ValuesIn(at_steps({0.5, 0.9 * limit}, 0, {holds, holds, holds, holds}) +
                      at_steps({0.5, 0.9 * limit, 0.25}, 0, {holds, holds, holds, holds}) +
                      at_steps({0.5, 0.5 * limit}, 0, {holds, holds, holds, holds}) +
                      at_steps({0.5, 0.5 * limit, 0.25}, 0, {holds, holds, holds, holds})),
    name_of);

// On triangles of 2 m no step misses. On small ones, long steps lose acceleration where vertices
// cross edges of the plane.
INSTANTIATE_TEST_SUITE_P(
    Steps, InclineSlides,
    testing::ValuesIn(at_steps({0.5, 1.3 * limit}, 0, {holds, holds, holds, holds}) +
                      at_steps({0.5, 1.3 * limit, 0.25}, 0, {holds, holds, holds, misses}) +
                      at_steps({0.5, 1.3 * limit, 0.0625}, 0, {holds, holds, holds, misses})),
    name_of);

INSTANTIATE_TEST_SUITE_P(Steps, Braking,
                         testing::ValuesIn(at_steps({0.2}, 1, {holds, holds, holds, misses}) +
                                           at_steps({0.2, 0, 0.25}, 1,
                                                    {holds, holds, holds, misses})),
                         name_of);

INSTANTIATE_TEST_SUITE_P(
    Steps, Conveyor,
    testing::ValuesIn(at_steps({0.3}, 2, {holds, holds, holds, holds}) +
                      at_steps({0.3, 0, 0.25}, 2, {holds, holds, misses, misses}) +
                      at_steps({0.3}, 10, {holds, holds, misses, misses}) +
                      at_steps({0.3, 0, 0.25}, 10, {misses, misses, misses, misses})),
    name_of);

INSTANTIATE_TEST_SUITE_P(Steps, ImpulseOfFriction,
                         testing::ValuesIn(at_steps({0.3}, 1, {misses, misses, misses, misses})),
                         name_of);

}  // namespace
}  // namespace weft::physics
