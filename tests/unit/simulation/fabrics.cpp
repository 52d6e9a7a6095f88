// Every fabric of the library drapes over a ball for a second without gaining energy, and a scene
// without materials is the default fabric.
#include "host/scene/fabric/fabrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/small_scenes.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

class FabricDrapes : public testing::TestWithParam<Fabric> {};

/// Largest length of an edge over its length at rest.
double largest_stretch(const Mesh& mesh, const std::vector<Vec3<double>>& x) {
  double largest = 0;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(t.v[k]);
      const auto b = static_cast<std::size_t>(t.v[(k + 1) % 3]);
      largest =
          std::max(largest, length(x[b] - x[a]) / length(mesh.material[b] - mesh.material[a]));
    }
  return largest;
}

TEST_P(FabricDrapes, StablyForASecond) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision, 10);
  scene.materials = {fabric(GetParam().name)};
  scene.time.step = 0.005;
  Simulation simulation(scene, host_devices(1));
  const double before = simulation.energy().total();
  double most = before;
  for (int k = 0; k < 200; ++k) {
    const StepReport report = simulation.step();
    ASSERT_EQ(report.failure, Failure::none) << k << ": " << report.failure_detail;
    most = std::max(most, simulation.energy().total());
  }
  const double at_play = GetParam().material.density * 0.16 * 9.81 * 0.4;
  // A sheet of 3e5 N/m that hits the ball in steps of the usual length gains a little by it.
  const double allowed = GetParam().name == std::string("paper") ? 0.05 : 0.01;
  EXPECT_LE(most - before, allowed * at_play);
  const Frame frame = simulation.frame();
  const std::vector<Vec3<double>>& x = frame.cloth_positions[0];
  double lowest = x[0][2], highest = x[0][2];
  for (const Vec3<double>& v : x) {
    lowest = std::min(lowest, v[2]);
    highest = std::max(highest, v[2]);
  }
  EXPECT_GT(highest - lowest, 0.01) << "it hangs down around the ball";
  EXPECT_LT(largest_stretch(scene.cloths[0].mesh, x), 1.15);
}

INSTANTIATE_TEST_SUITE_P(All, FabricDrapes, testing::ValuesIn(fabrics()),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(DefaultFabric, IsThatOfAProgramsSceneToo) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision, 6);
  scene.materials.clear();
  scene.cloths[0].material = 0;
  const Simulation simulation(scene, host_devices(1));
  ASSERT_EQ(simulation.scene().materials.size(), 1u);
  EXPECT_EQ(simulation.scene().materials[0].name, default_fabric);
  scene.cloths[0].material = 1;
  EXPECT_THROW(Simulation(scene, host_devices(1)), SceneError);
}

}  // namespace
}  // namespace weft
