// How far pins are from their places. Linked with the program's own objects, see
// tests/CMakeLists.txt.
#include "host/app/view/pin_distances.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace weft::app {
namespace {

/// A triangle whose first vertex is pinned, and lifted by 1 m within 1 s.
Scene pinned_triangle() {
  Scene scene;
  Cloth cloth;
  cloth.mesh.positions = {{1, 2, 3}, {2, 2, 3}, {1, 3, 3}};
  cloth.mesh.triangles = {{{0, 1, 2}}};
  scene.cloths = {cloth};
  Pin pin;
  pin.vertices = {0};
  pin.motion.resize(2);
  pin.motion[1].time = 1;
  pin.motion[1].transform.translate = {0, 0, 1};
  scene.pins = {pin};
  return scene;
}

std::vector<io::NamedMesh> cloths_of(const Scene& scene) {
  return {{"cloth", scene.cloths[0].mesh}};
}

TEST(PinDistances, AreThoseFromThePrescribedPlace) {
  const Scene scene = pinned_triangle();
  auto cloths = cloths_of(scene);
  cloths[0].mesh.positions[0] = {1, 2, 4.25};
  const auto distances = pin_distances(scene, cloths, 1);
  ASSERT_EQ(distances.size(), 1u);
  ASSERT_EQ(distances[0].size(), 3u);
  EXPECT_NEAR(distances[0][0], 0.25, 1e-6);
  EXPECT_TRUE(std::isnan(distances[0][1]));
  EXPECT_NEAR(pin_distances(scene, cloths, 0)[0][0], 1.25, 1e-6);
}

TEST(PinDistances, WithoutAMotionTheStartIsPrescribed) {
  Scene scene = pinned_triangle();
  scene.pins[0].motion.clear();
  auto cloths = cloths_of(scene);
  cloths[0].mesh.positions[0][0] += 0.5;
  EXPECT_NEAR(pin_distances(scene, cloths, 7)[0][0], 0.5, 1e-6);
}

TEST(PinDistances, LeaveOutWhatIsNotKnown) {
  Scene scene = pinned_triangle();
  EXPECT_TRUE(pin_distances(Scene{}, {}, 0).empty());
  scene.pins[0].release_time = 2;
  EXPECT_FALSE(pin_distances(scene, cloths_of(scene), 1.9).empty());
  EXPECT_TRUE(pin_distances(scene, cloths_of(scene), 2).empty()) << "it has let go";
  scene.pins[0].release_time = 9;
  auto remeshed = cloths_of(scene);
  remeshed[0].mesh.positions.push_back({0, 0, 0});
  EXPECT_TRUE(pin_distances(scene, remeshed, 0).empty());
  scene.pins[0].motion.clear();
  scene.pins[0].obstacle = 0;
  EXPECT_TRUE(pin_distances(scene, cloths_of(scene), 0).empty()) << "it follows an obstacle";
}

}  // namespace
}  // namespace weft::app
