#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

// Rayleigh damping, M a + K b, in all that stretches and bends: rates of decay in closed form, and
// what it means for a single step.

namespace weft {
namespace {

using std::numbers::pi;

constexpr double length_at_rest = 0.4;
constexpr double density = 0.15;
constexpr double stretch_stiffness = 200;
constexpr double bending_stiffness = 1e-5;

/// A strip without lateral contraction whose ends are held.
Scene strip(Bending bending, double stretch) {
  Scene s;
  s.precision = Precision::double_precision;
  s.gravity = {0, 0, 0};
  s.bending = bending;
  Material m = test::cotton();
  m.density = density;
  m.stretch_stiffness = stretch_stiffness;
  m.poisson_ratio = 0;
  m.bending_stiffness = bending_stiffness;
  m.damping_stiffness = 0;
  s.materials.push_back(m);
  Cloth cloth;
  cloth.name = "strip";
  cloth.mesh = make_grid({length_at_rest, length_at_rest / 8}, {32, 4}, Diagonals::alternating);
  Pin ends;
  for (std::size_t v = 0; v < cloth.mesh.positions.size(); ++v) {
    auto& p = cloth.mesh.positions[v];
    if (std::abs(p[0]) > 0.499 * length_at_rest) ends.vertices.push_back(static_cast<Index>(v));
    p[0] *= stretch;
  }
  s.cloths.push_back(cloth);
  s.pins.push_back(ends);
  s.contact.self = false;
  s.solver.tolerance = 1e-10;
  return s;
}

/// Amplitude, over the first one, to which the strip's slowest mode along an axis returns.
/// @param frequency [rad/s] without damping
double amplitude_after_a_period(Scene s, int axis, double frequency) {
  s.integrator = Integrator::bdf2;
  s.time.step = 2 * pi / frequency / 150;
  s.time.frame_rate = 1 / s.time.step;
  auto& positions = s.cloths[0].mesh.positions;
  const std::vector<Vec3<double>> rest = positions;
  const double half = positions.back()[0];
  const double amplitude = 1e-6;
  // cosines, that vanish at both ends
  for (auto& p : positions) p[axis] += amplitude * std::cos(pi / 2 * p[0] / half);
  const std::size_t middle = positions.size() / 2;
  Simulation simulation(s, host_devices(1));
  double largest = 0;
  for (int k = 1; k <= 165; ++k) {
    const StepReport report = simulation.step();
    EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
    const double now = simulation.frame().cloth_positions[0][middle][axis] - rest[middle][axis];
    if (k > 135) largest = std::max(largest, now);
  }
  return largest / amplitude;
}

/// A damped oscillator that is let go returns to exp(-zeta omega T) of where it was.
void expect_decay(const Scene& scene, int axis, double frequency) {
  const double zeta = 0.05;
  const double period = 2 * pi / (frequency * std::sqrt(1 - zeta * zeta));
  const double expected = std::exp(-zeta * frequency * period);
  Scene s = scene;
  EXPECT_NEAR(amplitude_after_a_period(s, axis, frequency), 1, 0.005) << "no damping";
  s.materials[0].damping_mass = 2 * zeta * frequency;
  EXPECT_NEAR(amplitude_after_a_period(s, axis, frequency), expected, 0.01) << "of the mass";
  s.materials[0].damping_mass = 0;
  s.materials[0].damping_stiffness = 2 * zeta / frequency;
  EXPECT_NEAR(amplitude_after_a_period(s, axis, frequency), expected, 0.01) << "of the stiffness";
}

TEST(Damping, OfAStripThatVibratesAlongItself) {
  expect_decay(strip(Bending::plate, 1), 0,
               pi / length_at_rest * std::sqrt(stretch_stiffness / density));
}

/// Stretched into its limit: with the stress S over the Green strain G, the force of an
/// elongation is S + stretch^2 dS/dG of it.
TEST(Damping, OfAStripAtItsStrainLimit) {
  const double stretch = 1.09, limit = 1.1;
  Scene s = strip(Bending::plate, stretch);
  s.materials[0].strain_limits = StrainLimits{0, limit};
  const double g = (stretch * stretch - 1) / 2, w = (limit * limit - 1) / 4;
  const double y = (g - w) / w;
  const double k = 20 * stretch_stiffness;
  const double stress = stretch_stiffness * g + k * w * y * y * y / 3;
  const double tangent = stretch_stiffness + k * y * y;
  EXPECT_GT(k * y * y, 5 * stretch_stiffness) << "this would test the law alone";
  expect_decay(s, 0,
               pi / length_at_rest * std::sqrt((stress + stretch * stretch * tangent) / density));
}

/// As a plate: the stiffness of hinges depends on the mesh.
TEST(Damping, OfABendingStrip) {
  Scene s = strip(Bending::plate, 1);
  s.solver.tolerance = 1e-7;  // rounding of the stiff stretch sets a floor
  expect_decay(
      s, 2, pi * pi / (length_at_rest * length_at_rest) * std::sqrt(bending_stiffness / density));
}

/// Displacements in a step that are due to velocities. It turns so little that the system remains
/// about its start.
std::vector<Vec3<double>> answer(Scene s, double h) {
  s.time.step = h;
  s.time.frame_rate = 1 / h;
  std::vector<Vec3<double>> sum;
  for (const double sign : {1.0, -1.0}) {
    Scene one = s;
    one.cloths[0].velocity = Vec3<double>{0.02, -0.01, 0.03} * sign;
    one.cloths[0].angular_velocity = Vec3<double>{0.1, 0.07, -0.04} * sign;
    Simulation simulation(one, host_devices(2));
    EXPECT_EQ(Failure::none, simulation.step().failure);
    const auto x = simulation.frame().cloth_positions[0];
    sum.resize(x.size(), Vec3<double>{0, 0, 0});
    for (std::size_t v = 0; v < x.size(); ++v) sum[v] += x[v] * (0.5 * sign);
  }
  return sum;
}

/// A step solves (M (1 + h a) + h (h + b) K) v = M v0 + h f. So with h' = sqrt(h (h + b) /
/// (1 + h a)) what v0 does with damping is, but for the factor 1 + h a, what it does in a step h'
/// without.
TEST(Damping, MakesAStepActLikeALongerOne) {
  const double h = 0.004, a = 30, b = 0.01;
  const double longer = std::sqrt(h * (h + b) / (1 + h * a));
  std::vector<Material> materials(4, strip(Bending::plate, 1).materials[0]);
  materials[0].poisson_ratio = 0.3;
  materials[1].orthotropic = OrthotropicStretch{200, 100, 0.2, 40};
  materials[1].orthotropic_bending = OrthotropicBending{3e-5, 1e-5, 2e-6, 4e-6};
  materials[2] = materials[1];
  materials[2].strain_limits = StrainLimits{0.9, 1.1};
  MeasuredStretch measured;
  measured.rows.fill({80, 10, 60, 40});
  materials[3].measured = measured;
  materials[3].strain_limits = StrainLimits{0.9, 1.1};
  for (const Bending bending : {Bending::plate, Bending::hinge})
    for (std::size_t m = 0; m < materials.size(); ++m) {
      SCOPED_TRACE(testing::Message() << "material " << m << ", bending " << int(bending));
      Scene s = strip(bending, 1.08);
      s.solver.tolerance = 1e-12;
      s.solver.newton_iterations = 1;
      s.materials[0] = materials[m];
      for (auto& p : s.cloths[0].mesh.positions) p[2] = 0.01 * std::sin(30 * p[0] + 20 * p[1]);
      const auto plain = answer(s, longer);
      s.materials[0].damping_mass = a;
      s.materials[0].damping_stiffness = b;
      const auto damped = answer(s, h);
      double largest = 0, error = 0;
      for (std::size_t v = 0; v < plain.size(); ++v) {
        const Vec3<double> expected = plain[v] * (h / longer / (1 + h * a));
        largest = std::max(largest, length(expected));
        error = std::max(error, length(damped[v] - expected));
      }
      EXPECT_GT(largest, 1e-5);
      EXPECT_LT(error, 1e-8 * largest);
    }
}

}  // namespace
}  // namespace weft
