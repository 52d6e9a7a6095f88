#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

// Closed surfaces and sheets under pressure in the whole engine; the formula is tested beside its
// element.

namespace weft {
namespace {

constexpr double radius = 0.2;
constexpr double stretch_stiffness = 300;
constexpr double poisson_ratio = 0.3;

/// A sphere whose triangles rest as they are, each a piece of the pattern of its own.
Cloth balloon(int subdivisions) {
  Cloth cloth;
  cloth.name = "balloon";
  cloth.mesh = make_icosphere(radius, subdivisions);
  Mesh& mesh = cloth.mesh;
  for (const Tri& t : mesh.triangles) {
    const auto at = [&](int c) { return mesh.positions[static_cast<std::size_t>(t.v[c])]; };
    const Vec3<double> along = at(1) - at(0), aside = at(2) - at(0);
    const double base = length(along);
    const double u = dot(along, aside) / base;
    const auto first = static_cast<Index>(mesh.material.size());
    mesh.material.push_back({0, 0});
    mesh.material.push_back({base, 0});
    mesh.material.push_back({u, std::sqrt(length_sq(aside) - u * u)});
    mesh.material_triangles.push_back({{first, first + 1, first + 2}});
  }
  return cloth;
}

Scene balloon_scene(int subdivisions, double stretch) {
  Scene s;
  s.precision = Precision::double_precision;
  s.gravity = {0, 0, 0};
  s.bending = Bending::hinge;  // of no stiffness
  s.materials.push_back(test::cotton());
  s.materials[0].stretch_stiffness = stretch_stiffness;
  s.materials[0].poisson_ratio = poisson_ratio;
  s.materials[0].bending_stiffness = 0;
  s.cloths.push_back(balloon(subdivisions));
  s.contact.self = false;
  s.solver.tolerance = 1e-10;
  // Tension stretch_stiffness / (1 - nu) (stretch^2 - 1) / 2 is pressure times half the radius.
  s.cloths[0].pressure =
      stretch_stiffness / (1 - poisson_ratio) * (stretch * stretch - 1) / (stretch * radius);
  return s;
}

double mean_radius(const Simulation& simulation) {
  const auto x = simulation.frame().cloth_positions[0];
  double sum = 0;
  for (const auto& p : x) sum += length(p) / static_cast<double>(x.size());
  return sum;
}

TEST(Pressure, NewtonInflatesABalloonToLaplacesRadius) {
  for (const double stretch : {1.02, 1.3}) {
    double error[2];
    for (const int subdivisions : {2, 3}) {
      Scene s = balloon_scene(subdivisions, stretch);
      // Far above the slowest period: one step is the way to the equilibrium.
      s.time.step = 100;
      s.time.frame_rate = 0.01;
      s.solver.newton_iterations = 60;
      s.solver.newton_tolerance = 1e-8;
      Simulation simulation(s, host_devices(2));
      const StepReport report = simulation.step();
      ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
      EXPECT_LE(report.newton_residual, 1e-8) << stretch;
      EXPECT_LT(report.newton_iterations, 60) << stretch;
      error[subdivisions - 2] = mean_radius(simulation) / (stretch * radius) - 1;
    }
    // Chords instead of arcs: half of the error of area over volume, at second order.
    EXPECT_LT(std::abs(error[1]), 0.005) << stretch;
    EXPECT_NEAR(2, std::log2(error[0] / error[1]), 0.2) << stretch;
  }
}

TEST(Pressure, LinearStepsInflateABalloonAtAnyLength) {
  for (const double step : {0.005, 0.1, 1.0}) {
    Scene s = balloon_scene(2, 1.3);
    s.solver.newton_iterations = 60;
    s.solver.newton_tolerance = 1e-8;
    s.time.step = 100;
    s.time.frame_rate = 0.01;
    Simulation newton(s, host_devices(1));
    for (int k = 0; k < 3; ++k) ASSERT_EQ(Failure::none, newton.step().failure);
    s.solver.newton_iterations = 1;
    s.time.step = step;
    s.time.frame_rate = 1 / step;
    s.materials[0].damping_mass = 20;
    Simulation simulation(s, host_devices(1));
    for (int k = 0; k < 300; ++k) ASSERT_EQ(Failure::none, simulation.step().failure);
    EXPECT_NEAR(mean_radius(simulation), mean_radius(newton), 1e-6 * radius) << step;
  }
}

/// Pressure does not move a closed surface as a whole.
TEST(Pressure, OfAClosedSurfaceKeepsItsMomentum) {
  Scene s = balloon_scene(2, 1.4);
  s.cloths[0].velocity = {0.3, -0.2, 0.1};
  for (auto& p : s.cloths[0].mesh.positions) p[0] *= 1.1;
  s.solver.tolerance = 1e-11;
  std::vector<double> mass(s.cloths[0].mesh.positions.size(), 0);
  const Mesh& mesh = s.cloths[0].mesh;
  double total = 0;
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    const Vec2<double> a = mesh.material[3 * n + 1], b = mesh.material[3 * n + 2];
    total += a[0] * b[1];
    for (const Index v : mesh.triangles[n].v) mass[static_cast<std::size_t>(v)] += a[0] * b[1] / 3;
  }
  Simulation simulation(s, host_devices(3));
  const auto centre = [&] {
    const auto x = simulation.frame().cloth_positions[0];
    Vec3<double> sum{0, 0, 0};
    for (std::size_t v = 0; v < x.size(); ++v) sum += x[v] * (mass[v] / total);
    return sum;
  };
  const Vec3<double> start = centre();
  for (int k = 0; k < 10; ++k) {
    const StepReport report = simulation.step();
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
  }
  EXPECT_GT(mean_radius(simulation), 1.1 * radius);
  // The impulse of pressure, some 0.3 N s in the 2-norm, times the solver's tolerance, times the
  // root of 162 vertices, over 0.074 kg, for 0.05 s.
  EXPECT_LT(length(centre() - start - s.cloths[0].velocity * (10 * s.time.step)), 3e-11);
}

/// The first step from rest: velocity h pressure area / mass, along the normal.
TEST(Pressure, AcceleratesAFlatSheetAlongItsNormal) {
  for (const double pressure : {3.0, -3.0}) {
    Scene s;
    s.precision = Precision::double_precision;
    s.gravity = {0, 0, 0};
    s.materials.push_back(test::cotton());
    s.cloths.push_back(test::sheet(6, 0));
    s.cloths[0].pressure = pressure;
    s.contact.self = false;
    s.solver.tolerance = 1e-12;
    Simulation simulation(s, host_devices(2));
    for (int k = 0; k < 10; ++k) ASSERT_EQ(Failure::none, simulation.step().failure);
    const double h = s.time.step;
    const double z = pressure / s.materials[0].density * h * h * 10 * 11 / 2;
    const auto x = simulation.frame().cloth_positions[0];
    for (const auto& p : x) EXPECT_NEAR(z, p[2], 1e-10);
  }
}

/// Only where it is set, and with the same bits for any number of ranks.
TEST(Pressure, IsOfItsClothAlone) {
  const auto run = [](int ranks) {
    Scene s;
    s.precision = Precision::single_precision;
    s.gravity = {0, 0, 0};
    s.materials.push_back(test::cotton());
    s.cloths = {test::sheet(8, 0), test::sheet(8, 0.3)};
    s.cloths[1].name = "other";
    s.cloths[1].pressure = 50;
    s.solver.partial_rows = 8;
    s.solver.tolerance = 1e-6;
    Simulation simulation(s, host_devices(ranks));
    for (int k = 0; k < 5; ++k) EXPECT_EQ(Failure::none, simulation.step().failure);
    const Frame frame = simulation.frame();
    for (const auto& p : frame.cloth_positions[0]) EXPECT_NEAR(0, p[2], 1e-6);
    for (const auto& p : frame.cloth_positions[1]) EXPECT_GT(p[2], 0.31);
    return simulation.state_hash();
  };
  const auto one = run(1);
  for (const int ranks : {2, 3, 5}) EXPECT_EQ(one, run(ranks)) << ranks;
}

}  // namespace
}  // namespace weft
