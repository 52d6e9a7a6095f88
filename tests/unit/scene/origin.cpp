#include "host/scene/origin.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_scenes.hpp"

namespace weft {
namespace {

constexpr Vec3<double> zero{0, 0, 0};
constexpr Vec3<double> far{0x1p20, -0x1p18, 0x1p10};

TEST(Origin, OfAnOrdinarySceneIsZeroAndChangesNothing) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  const Scene before = scene;
  choose_origin(scene);
  EXPECT_EQ(scene.origin, zero);
  EXPECT_EQ(scene.cloths[0].mesh.positions, before.cloths[0].mesh.positions);
}

TEST(Origin, GivenIsKept) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  scene.origin = far;
  const auto positions = scene.cloths[0].mesh.positions;
  choose_origin(scene);
  EXPECT_EQ(scene.origin, far);
  EXPECT_EQ(scene.cloths[0].mesh.positions, positions);
}

TEST(Origin, MovesEveryPlaceOfAScene) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  scene.cloths[0].rest_positions = scene.cloths[0].mesh.positions;
  for (auto& x : scene.cloths[0].rest_positions) x += far;  // where the cloth of a far scene is
  scene.obstacles[0].driven = DrivenBody{};
  scene.obstacles[0].motion = {{0, {}}, {1, {}}};
  scene.handles.resize(1);
  scene.handles[0].carrier.start = {zero};
  scene.camera.keys.resize(2);
  const Scene before = scene;
  move_origin(scene, far);
  EXPECT_EQ(scene.origin, far);
  EXPECT_EQ(scene.cloths[0].mesh.positions[3], before.cloths[0].mesh.positions[3] - far);
  EXPECT_EQ(scene.cloths[0].velocity_origin, zero - far);
  EXPECT_EQ(scene.cloths[0].rest_positions[3], before.cloths[0].rest_positions[3] - far);
  EXPECT_EQ(scene.obstacles[0].mesh.positions, before.obstacles[0].mesh.positions);
  EXPECT_EQ(scene.obstacles[0].transform.translate, before.obstacles[0].transform.translate - far);
  EXPECT_EQ(scene.obstacles[0].motion[1].transform.translate, zero - far);
  EXPECT_EQ(scene.obstacles[0].driven->origin, zero - far);
  EXPECT_EQ(scene.handles[0].center, zero - far);
  EXPECT_EQ(scene.handles[0].carrier.start[0], zero - far);
  EXPECT_EQ(scene.camera.keys[1].position, zero - far);
  EXPECT_EQ(scene.camera.keys[1].look_at, zero - far);
  move_origin(scene, zero);
  EXPECT_EQ(scene.handles[0].center, zero);
}

TEST(Origin, RestShapeElsewhereIsNotCarriedAway) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  scene.cloths[0].rest_positions = scene.cloths[0].mesh.positions;
  const auto rest = scene.cloths[0].rest_positions;
  move_origin(scene, far);
  EXPECT_EQ(scene.cloths[0].rest_positions, rest);
}

TEST(Origin, TranslationsHaveTheSameBitsAnywhere) {
  const Transform transform{{0.1, 0.2, 0.3}, {0, 0, 1}, 0, 1};
  const Vec3<double> x{0.7, 0.011, -0.3};
  EXPECT_EQ(apply_in_world(transform, x, far), apply(transform, x));
}

TEST(Origin, RotationsAboutAnAxisThroughItHaveTheSameBits) {
  const Transform transform{{0.1, 0.2, 0.3}, {0, 0, 1}, 0.83, 1};
  const Vec3<double> x{0.7, 0.011, -0.3};
  EXPECT_EQ(apply_in_world(transform, x, {0, 0, 123456.7}), apply(transform, x));
}

TEST(Origin, OtherMotionsAreThoseOfWorldPositions) {
  const Transform transform{{0.1, 0.2, 0.3}, {0.6, 0, 0.8}, 0.83, 1.25};
  const Vec3<double> x{0.7, 0.011, -0.3};
  const Vec3<double> origin{1000, -300, 70};
  const Vec3<double> found = apply_in_world(transform, x, origin) + origin;
  const Vec3<double> expected = apply(transform, x + origin);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], expected[k], 1e-11);
}

}  // namespace
}  // namespace weft
