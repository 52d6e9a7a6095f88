#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "host/model/material_rows.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/elements/membrane.hpp"
#include "weft/simulation.hpp"

// Strain limits in the whole engine; their formula is tested beside its element.

namespace weft {
namespace {

constexpr double least = 0.9;
constexpr double greatest = 1.1;

/// Soft cloth: hung by two corners it would stretch by more than half.
Material soft() {
  Material m = test::cotton();
  m.density = 0.2;
  m.stretch_stiffness = 20;
  m.damping_stiffness = 0;
  m.strain_limits = StrainLimits{least, greatest};
  return m;
}

/// The soft sheet by all laws.
std::vector<Material> laws() {
  std::vector<Material> all(4, soft());
  all[1].orthotropic = OrthotropicStretch{20, 10, 0.2, 5};
  MeasuredStretch measured;
  measured.rows.fill({10, 2, 5, 4});
  all[2].measured = measured;
  measured.form = MeasuredStretch::Form::arcsim;
  all[3].measured = measured;
  return all;
}

const char* name_of(const Material& m) {
  if (m.measured) return m.measured->form == MeasuredStretch::Form::energy ? "wang" : "wang_arcsim";
  return m.orthotropic ? "orthotropic" : "isotropic";
}

/// A vertical sheet of side 0.4 m that hangs by its upper corners.
Scene hanging(const Material& material, int cells, Precision precision) {
  Scene s;
  s.precision = precision;
  s.materials.push_back(material);
  s.cloths.push_back(test::sheet(cells, 0));
  for (auto& p : s.cloths[0].mesh.positions) p = {p[0], 0, p[1]};
  const Index last = static_cast<Index>(s.cloths[0].mesh.positions.size()) - 1;
  s.pins.push_back({0, {last - cells, last}, {}, -1, 1e9});
  s.contact.self = false;
  s.solver.tolerance = 1e-3;
  return s;
}

struct Stretches {
  double least = 1e30, greatest = 0;
};

Stretches stretches(const Scene& scene, const Simulation& simulation) {
  const auto positions = simulation.frame().cloth_positions[0];
  const Mesh& mesh = scene.cloths[0].mesh;
  Stretches all;
  for (const Tri& t : mesh.triangles) {
    const auto at = [&](int c) { return static_cast<std::size_t>(t.v[c]); };
    const Vec3<double> x[3] = {positions[at(0)], positions[at(1)], positions[at(2)]};
    const Vec2<double> a = mesh.material[at(1)] - mesh.material[at(0)];
    const Vec2<double> b = mesh.material[at(2)] - mesh.material[at(0)];
    const double det = a[0] * b[1] - a[1] * b[0];
    const auto g =
        detail::membrane_strain(x, Mat2<double>{{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}})
            .green;
    const double mean = (g.xx + g.yy) / 2;
    const double radius = std::hypot((g.xx - g.yy) / 2, g.xy);
    all.least = std::min(all.least, std::sqrt(std::max(0.0, 1 + 2 * (mean - radius))));
    all.greatest = std::max(all.greatest, std::sqrt(1 + 2 * (mean + radius)));
  }
  return all;
}

/// Least and greatest stretch over some steps.
Stretches worst_of(const Scene& scene, int steps) {
  Simulation simulation(scene, host_devices(1));
  Stretches worst;
  for (int k = 0; k < steps; ++k) {
    const StepReport report = simulation.step();
    EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
    const Stretches now = stretches(scene, simulation);
    worst.least = std::min(worst.least, now.least);
    worst.greatest = std::max(worst.greatest, now.greatest);
  }
  return worst;
}

/// From the drop into the corners until it hangs: without limits it stretches by half and more.
TEST(StrainLimits, HoldAHangingSheetOfAnyLaw) {
  for (const Material& material : laws())
    for (const int newton : {1, 4})
      for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
        if (newton > 1 && precision == Precision::double_precision) continue;
        SCOPED_TRACE(name_of(material) + std::string(newton > 1 ? " Newton" : " linear"));
        Scene s = hanging(material, 16, precision);
        s.solver.newton_iterations = newton;
        const Stretches worst = worst_of(s, 50);
        EXPECT_GE(worst.least, least);
        EXPECT_LE(worst.greatest, greatest);
        EXPECT_GT(worst.greatest, (1 + greatest) / 2) << "this would test nothing";
      }
  Scene free = hanging(soft(), 16, Precision::single_precision);
  free.materials[0].strain_limits.reset();
  EXPECT_GT(worst_of(free, 50).greatest, 1.4);
}

/// The finer the mesh, the greater the load on a corner's triangle.
TEST(StrainLimits, HoldWhereAllHangsByOneTriangle) {
  const Stretches worst = worst_of(hanging(soft(), 32, Precision::single_precision), 50);
  EXPECT_GE(worst.least, least);
  EXPECT_LE(worst.greatest, greatest);
}

/// Flat, so that it cannot escape sideways.
TEST(StrainLimits, TakeBackASheetThatStartsOutside) {
  for (const Material& material : laws())
    for (const int newton : {1, 8})
      for (const double scale : {0.3, 0.7, 1.4, 3.0}) {
        SCOPED_TRACE(testing::Message() << name_of(material) << " " << newton << " " << scale);
        Scene s = hanging(material, 8, Precision::single_precision);
        s.pins.clear();
        s.gravity = {0, 0, 0};
        s.materials[0].damping_mass = 40;
        s.solver.newton_iterations = newton;
        for (auto& p : s.cloths[0].mesh.positions) p *= scale;
        Simulation simulation(s, host_devices(1));
        for (int k = 0; k < 40; ++k) {
          const StepReport report = simulation.step();
          ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
        }
        const Stretches now = stretches(s, simulation);
        EXPECT_GE(now.least, least);
        EXPECT_LE(now.greatest, greatest);
      }
}

TEST(StrainLimits, SameBitsOnAnyNumberOfRanks) {
  const auto hash = [](int ranks) {
    Scene s = hanging(soft(), 10, Precision::single_precision);
    s.solver.partial_rows = 8;
    Simulation simulation(s, host_devices(ranks));
    for (int k = 0; k < 20; ++k) EXPECT_EQ(Failure::none, simulation.step().failure);
    return simulation.state_hash();
  };
  const auto one = hash(1);
  for (const int ranks : {2, 3}) EXPECT_EQ(hash(ranks), one) << ranks;
}

/// Newton iterations a step, the fastest vertex at the end of a step, and where all end.
struct Swing {
  double iterations = 0;
  double fastest = 0;  ///< [m/s]
  std::vector<Vec3<double>> end;
};
Swing swing(double step, int newton_iterations, int ranks = 1) {
  Material material = soft();
  material.density = 0.15;
  material.stretch_stiffness = 2.6;
  material.strain_limits = StrainLimits{0, 1.06};
  Scene s = hanging(material, 12, Precision::single_precision);
  s.time.step = step;
  s.solver.newton_iterations = newton_iterations;
  s.solver.partial_rows = 8;
  Simulation simulation(s, host_devices(ranks));
  Swing result;
  const int steps = static_cast<int>(std::lround(1.2 / step));
  result.end = simulation.frame().cloth_positions[0];
  for (int n = 0; n < steps; ++n) {
    const StepReport report = simulation.step();
    EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
    result.iterations += report.newton_iterations / double(steps);
    const auto before = std::exchange(result.end, simulation.frame().cloth_positions[0]);
    for (std::size_t v = 0; v < before.size(); ++v)
      result.fastest = std::max(result.fastest, length(result.end[v] - before[v]) / step);
  }
  return result;
}

/// Largest elastic energy [J] and stretch at the ends of steps.
struct Peak {
  double elastic = 0, stretch = 0;
};
Peak peak(const Material& material, double step, int newton_iterations) {
  Scene s = hanging(material, 12, Precision::single_precision);
  s.time.step = step;
  s.time.frame_rate = 1 / step;
  s.solver.newton_iterations = newton_iterations;
  Simulation simulation(s, host_devices(1));
  Peak result;
  const int steps = static_cast<int>(std::lround(0.6 / step));
  for (int n = 0; n < steps; ++n) {
    const StepReport report = simulation.step();
    EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
    result.elastic = std::max(result.elastic, simulation.energy().elastic);
    result.stretch = std::max(result.stretch, stretches(s, simulation).greatest);
    EXPECT_EQ(0, report.limit_excess.value_or(1));
  }
  return result;
}

/// The sheet falls into limits a thousand times as stiff as it.
TEST(StrainLimits, AThousandTimesStifferThanTheClothStartWithoutAJump) {
  Material material = soft();
  material.density = 0.15;
  material.strain_limits = StrainLimits{0, 1.06};
  material.stretch_stiffness =
      1e-3 * material_rows<double>({material}, {{}}).rows[0].limits.high.stiffness;
  for (const double step : {0.04, 0.02, 0.01, 0.004}) {
    SCOPED_TRACE(step);
    const Peak adaptive = peak(material, step, 0), newton = peak(material, step, 20);
    EXPECT_LE(adaptive.elastic, 2 * newton.elastic);
    EXPECT_GE(adaptive.elastic, newton.elastic / 2);
    EXPECT_LE(adaptive.stretch, 1.06);
    EXPECT_GT(adaptive.stretch, 1.03) << "this would test nothing";
  }
}

/// Pinned farther apart than the limit allows: the run goes on and says by how much.
TEST(StrainLimits, SayWhatPinsForce) {
  Scene s = hanging(soft(), 6, Precision::double_precision);
  s.time.step = 0.01;
  s.time.frame_rate = 100;
  Pin pull = s.pins[0];
  s.pins[0].vertices.pop_back();
  pull.vertices.erase(pull.vertices.begin());
  pull.motion.resize(2);
  pull.motion[1].time = 0.5;
  pull.motion[1].transform.translate = {0.08, 0, 0};
  s.pins.push_back(pull);
  Simulation simulation(s, host_devices(1));
  StepReport report;
  for (int k = 0; k < 50; ++k) {
    report = simulation.step();
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
    ASSERT_TRUE(report.limit_excess.has_value());
  }
  const double expected = (stretches(s, simulation).greatest - greatest) / (greatest - 1);
  EXPECT_GT(expected, 0.5);
  EXPECT_NEAR(expected, *report.limit_excess, 1e-9);
}

/// A single linear solve does not know of limits that cloth reaches within the step.
TEST(StrainLimits, LongStepsTurnToNewtonsMethod) {
  const Swing adaptive = swing(0.04, 0), linear = swing(0.04, 1);
  EXPECT_GT(adaptive.iterations, 1.5);
  EXPECT_GT(linear.fastest, 1.5 * adaptive.fastest);
  EXPECT_LT(swing(0.0005, 0).iterations, 1.1) << "short steps do without";
  const Swing shared = swing(0.04, 0, 3);
  for (std::size_t v = 0; v < shared.end.size(); ++v)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(adaptive.end[v][c], shared.end[v][c]) << v;
}

}  // namespace
}  // namespace weft
