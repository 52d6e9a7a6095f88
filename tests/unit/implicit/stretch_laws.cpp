#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

// The laws of stretching in the whole engine, tables and all; their formulas are tested beside
// their elements.

namespace weft {
namespace {

constexpr double density = 0.15;
constexpr double warp = 900;
constexpr double weft = 225;
constexpr double shear = 200;
constexpr double side = 0.4;

Material of_threads() {
  Material m = test::cotton();
  m.density = density;
  m.bending_stiffness = 0;
  m.damping_stiffness = 0;
  m.poisson_ratio = 0;
  return m;
}

/// The same orthotropic sheet in all ways to say it.
std::vector<Material> same_sheet() {
  std::vector<Material> all(3, of_threads());
  all[0].orthotropic = OrthotropicStretch{warp, weft, 0, shear};
  // tables hold half of the stiffness, and c33 is twice the shear stiffness
  MeasuredStretch measured;
  measured.rows.fill({warp / 2, 0, weft / 2, shear});
  measured.form = MeasuredStretch::Form::energy;
  all[1].measured = measured;
  measured.form = MeasuredStretch::Form::arcsim;
  all[2].measured = measured;
  return all;
}

Scene free_sheet(const Material& material, int cells) {
  Scene s;
  s.precision = Precision::double_precision;
  s.gravity = {0, 0, 0};
  s.materials.push_back(material);
  s.cloths.push_back(test::sheet(cells, 0));
  s.contact.self = false;
  s.solver.tolerance = 1e-9;
  s.solver.newton_iterations = 3;
  return s;
}

/// Time at which a free sheet in its first longitudinal mode along an axis is back at rest length,
/// over a quarter of the period of a bar: side / 2 sqrt(density / stiffness).
double quarter_period_share(const Material& material, int axis, double stiffness) {
  Scene s = free_sheet(material, 16);
  const double expected = side / 2 * std::sqrt(density / stiffness);
  s.integrator = Integrator::bdf2;
  s.time.step = expected / 60;
  s.time.frame_rate = 1 / (60 * s.time.step);
  auto& positions = s.cloths[0].mesh.positions;
  const std::vector<Vec3<double>> rest = positions;
  for (auto& p : positions) p[axis] += 1e-4 * std::sin(std::numbers::pi * p[axis] / side);
  Simulation simulation(s, host_devices(1));
  const std::size_t corner = rest.size() - 1;
  double before = positions[corner][axis] - rest[corner][axis];
  for (int k = 1; k <= 90; ++k) {
    EXPECT_EQ(simulation.step().failure, Failure::none);
    const double now = simulation.frame().cloth_positions[0][corner][axis] - rest[corner][axis];
    if (now <= 0) return (k - 1 + before / (before - now)) / 60;
    before = now;
  }
  return 0;
}

TEST(StretchLaws, VibrateAsBarsOfTheirThreads) {
  for (const Material& m : same_sheet()) {
    SCOPED_TRACE(m.orthotropic                                       ? "orthotropic"
                 : m.measured->form == MeasuredStretch::Form::arcsim ? "wang_arcsim"
                                                                     : "wang");
    EXPECT_NEAR(quarter_period_share(m, 0, warp), 1, 0.01);
    EXPECT_NEAR(quarter_period_share(m, 1, weft), 1, 0.01);
  }
}

/// A sheet of all laws at once, under way.
Scene patchwork() {
  Scene s = free_sheet(of_threads(), 12);
  for (const Material& m : same_sheet()) s.materials.push_back(m);
  s.materials[1].damping_stiffness = 1e-4;
  s.materials[3].measured->rows[0] = {200, 30, 80, 10};
  s.precision = Precision::single_precision;
  s.solver.tolerance = 1e-3;
  s.solver.partial_rows = 8;
  Cloth& cloth = s.cloths[0];
  for (std::size_t t = 0; t < cloth.mesh.triangles.size(); ++t)
    cloth.triangle_material.push_back(static_cast<Index>(t % s.materials.size()));
  for (auto& p : cloth.mesh.positions) {
    p[0] *= 1.05;
    p[1] *= 0.97;
    p[2] += 0.01 * std::sin(20 * p[0]);
  }
  return s;
}

TEST(StretchLaws, SameBitsOnAnyNumberOfRanks) {
  const auto hash = [](int ranks) {
    Simulation simulation(patchwork(), host_devices(ranks));
    for (int k = 0; k < 6; ++k) EXPECT_EQ(simulation.step().failure, Failure::none);
    return simulation.state_hash();
  };
  const auto one = hash(1);
  for (const int ranks : {2, 3, 5}) EXPECT_EQ(hash(ranks), one) << ranks;
}

TEST(StretchLaws, KeepMomentum) {
  Scene s = patchwork();
  s.precision = Precision::double_precision;
  s.solver.tolerance = 1e-13;
  s.cloths[0].velocity = {0.3, -0.2, 0.1};
  Simulation simulation(s, host_devices(2));
  const auto centre = [&] {
    // all have one density, so that equal cells of the grid weigh the same
    const auto& mesh = s.cloths[0].mesh;
    const auto x = simulation.frame().cloth_positions[0];
    Vec3<double> sum{0, 0, 0};
    for (const Tri& t : mesh.triangles)
      for (const Index v : t.v) sum += x[static_cast<std::size_t>(v)];
    return sum * (1 / (3.0 * static_cast<double>(mesh.triangles.size())));
  };
  const Vec3<double> start = centre();
  for (int k = 0; k < 4; ++k) EXPECT_EQ(simulation.step().failure, Failure::none);
  const double t = 4 * s.time.step;
  EXPECT_LT(length(centre() - start - s.cloths[0].velocity * t), 1e-12);
}

}  // namespace
}  // namespace weft
