// Cloth of any size: no length of the engine is absolute. If sizes change by powers of four, times
// by the root of that, and fabrics so that all dimensionless groups stay, every number changes by a
// power of two, which rounds nothing: states have the same bits but for their scale.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// The scene 4^power times as large, under the same gravity and of the same mass per area.
Scene scaled(Scene scene, int power) {
  const double size = std::ldexp(1.0, 2 * power);
  const double time = std::ldexp(1.0, power);
  const auto scale = [&](Motion& motion) {
    for (Keyframe& key : motion) {
      key.time *= time;
      key.transform.translate *= size;
    }
  };
  scene.time.step *= time;
  scene.time.frame_rate /= time;
  for (Material& m : scene.materials) {
    m.stretch_stiffness *= size;
    m.bending_stiffness *= size * size * size;
    m.damping_mass /= time;
    m.damping_stiffness *= time;
  }
  for (Cloth& cloth : scene.cloths) {
    for (Vec3<double>& x : cloth.mesh.positions) x *= size;
    for (Vec2<double>& u : cloth.mesh.material) u *= size;
    for (Vec3<double>& x : cloth.rest_positions) x *= size;
    cloth.velocity *= time;
    cloth.angular_velocity *= 1 / time;
    cloth.velocity_origin *= size;
  }
  for (Obstacle& obstacle : scene.obstacles) {
    for (Vec3<double>& x : obstacle.mesh.positions) x *= size;
    obstacle.transform.translate *= size;
    scale(obstacle.motion);
  }
  for (Pin& pin : scene.pins) {
    pin.release_time *= time;
    scale(pin.motion);
  }
  scene.contact.thickness = size * contact_thickness(scene.contact);
  return scene;
}

struct SizeCase {
  std::string name;
  std::function<Scene(Precision)> scene;
  int steps;
};

std::ostream& operator<<(std::ostream& out, const SizeCase& c) {
  return out << c.name;
}

class AnySize : public testing::TestWithParam<SizeCase> {};

TEST_P(AnySize, HasTheSameMotion) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const Scene scene = GetParam().scene(precision);
    Simulation unit(scene, host_devices(1));
    std::vector<std::pair<int, Simulation>> others;
    for (const int power : {-5, -1, 1, 5})
      others.emplace_back(power, Simulation(scaled(scene, power), host_devices(1)));
    bool touched = false;
    for (int k = 0; k < GetParam().steps; ++k) {
      const StepReport report = unit.step();
      ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
      touched = touched || report.proximities > 0;
      const Frame frame = unit.frame();
      for (auto& [power, other] : others) {
        ASSERT_EQ(other.step().failure, Failure::none) << "4^" << power;
        const Frame scaled_frame = other.frame();
        const double size = std::ldexp(1.0, 2 * power);
        for (std::size_t c = 0; c < frame.cloth_positions.size(); ++c)
          for (std::size_t v = 0; v < frame.cloth_positions[c].size(); ++v)
            ASSERT_EQ(scaled_frame.cloth_positions[c][v], size * frame.cloth_positions[c][v])
                << "size 4^" << power << ", step " << k + 1 << ", vertex " << v;
      }
    }
    EXPECT_TRUE(touched || unit.scene().obstacles.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Size, AnySize,
    testing::Values(
        SizeCase{"SheetOnSphere", [](Precision p) { return test::sheet_on_sphere(p); }, 60},
        SizeCase{"TwoSheets", [](Precision p) { return test::two_sheets(p); }, 60},
        SizeCase{"HangingSheet",
                 [](Precision p) { return test::hanging_sheet(p, Integrator::bdf2); }, 30},
        SizeCase{"CurledSheet", [](Precision p) { return test::curled_sheet(p, Bending::plate); },
                 30},
        SizeCase{"FoldedNapkin", [](Precision p) { return test::folded_napkin(p); }, 30}),
    [](const auto& of) { return of.param.name; });

}  // namespace
}  // namespace weft
