// Scenes far from (0, 0, 0): the state is that of the same scene at (0, 0, 0), bit for bit where
// adding the offset rounds nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "host/base/scratch_folder.hpp"
#include "host/model/deformation.hpp"
#include "host/time_parallel/slices.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr Vec3<double> offset{0x1p20, -0x1p18, 0x1p10};
constexpr Vec3<double> zero{0, 0, 0};

/// Adding the offset to a multiple of this rounds nothing.
void snap(Vec3<double>& x) {
  for (int k = 0; k < 3; ++k) x[k] = std::ldexp(std::round(std::ldexp(x[k], 30)), -30);
}

Scene snapped(Scene scene) {
  for (Cloth& cloth : scene.cloths)
    for (Vec3<double>& x : cloth.mesh.positions) snap(x);
  for (Obstacle& obstacle : scene.obstacles) {
    snap(obstacle.transform.translate);
    for (Keyframe& key : obstacle.motion) snap(key.transform.translate);
  }
  for (Handle& handle : scene.handles) snap(handle.center);
  for (CameraKey& key : scene.camera.keys) {
    snap(key.position);
    snap(key.look_at);
  }
  return scene;
}

/// The scene somewhere else, as a user would write it there.
Scene moved(Scene scene, const Vec3<double>& by) {
  for (Cloth& cloth : scene.cloths) {
    for (Vec3<double>& x : cloth.mesh.positions) x += by;
    cloth.velocity_origin += by;
  }
  for (Obstacle& obstacle : scene.obstacles) {
    obstacle.transform.translate += by;
    for (Keyframe& key : obstacle.motion) key.transform.translate += by;
    if (obstacle.driven) obstacle.driven->origin += by;
  }
  for (Handle& handle : scene.handles) handle.center += by;
  for (CameraKey& key : scene.camera.keys) {
    key.position += by;
    key.look_at += by;
  }
  return scene;
}

void expect_moved(const std::vector<std::vector<Vec3<double>>>& far,
                  const std::vector<std::vector<Vec3<double>>>& near) {
  ASSERT_EQ(far.size(), near.size());
  for (std::size_t i = 0; i < far.size(); ++i) {
    ASSERT_EQ(far[i].size(), near[i].size());
    for (std::size_t v = 0; v < far[i].size(); ++v) ASSERT_EQ(far[i][v], near[i][v] + offset);
  }
}

void expect_same_bits(const Scene& scene, int steps, int ranks = 1) {
  Simulation near(snapped(scene), host_devices(ranks));
  Simulation far(moved(snapped(scene), offset), host_devices(ranks));
  EXPECT_EQ(near.origin(), zero);
  EXPECT_EQ(far.origin(), offset);
  for (int k = 0; k <= steps; ++k) {
    ASSERT_EQ(far.state_hash(), near.state_hash()) << "step " << k;
    ASSERT_EQ(far.energy().gravitational, near.energy().gravitational);
    const Frame here = near.frame(), there = far.frame(), local = far.local_frame();
    EXPECT_EQ(there.origin, zero);
    EXPECT_EQ(local.origin, offset);
    EXPECT_EQ(local.cloth_positions, here.cloth_positions);
    expect_moved(there.cloth_positions, here.cloth_positions);
    expect_moved(there.obstacle_positions, here.obstacle_positions);
    if (k == steps) break;
    const StepReport report = near.step();
    ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
    ASSERT_EQ(far.step().failure, Failure::none);
  }
}

/// A sheet that is held, drawn and blown, above a ball that turns and a floor that heaves.
Scene everything(Precision precision) {
  Scene scene = test::hanging_sheet(precision, Integrator::bdf2);
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.08, 1);
  ball.motion = {{0, {{0, 0, -0.13}, {0, 1, 0}, 0, 1}},
                 {0.2, {{0.02, 0, -0.1}, {0, 1, 0}, 1.5, 1}}};
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = make_box({0.6, 0.6, 0.1}, {2, 2, 1});
  floor.transform.translate = {0, 0, -0.3};
  auto shape = std::make_shared<SampledDeformation>(Interpolation::cubic);
  for (int frame = 0; frame < 3; ++frame) {
    auto positions = floor.mesh.positions;
    for (auto& x : positions) x[2] += 0.0123 * frame * x[0];
    shape->add_frame(0.1 * frame, Span<const Vec3<double>>(positions.data(), positions.size()));
  }
  shape->positions(0, floor.mesh.positions);
  floor.deformation = shape;
  scene.obstacles = {ball, floor};
  Handle drawn;
  drawn.vertices = {60, 61};
  drawn.stiffness = 5;
  drawn.motion = {{0, {}}, {0.1, {{0.01, 0, 0.03}, {0, 0, 1}, 0, 1}}};
  Handle wound;
  wound.shape = Handle::Shape::circle;
  wound.vertices = {110, 111, 112};
  wound.stiffness = 5;
  wound.circumference = 0.3;
  wound.center = {-0.2, 0.2, 0.03};
  scene.handles = {drawn, wound};
  scene.wind = {1.2, {1, 0.5, 0}, 0};
  scene.cloths[0].angular_velocity = {0.2, 0, 0.1};
  return scene;
}

TEST(FarScene, SameBitsInSinglePrecision) {
  expect_same_bits(everything(Precision::single_precision), 20);
}

TEST(FarScene, SameBitsInDoublePrecisionOnSeveralRanks) {
  expect_same_bits(everything(Precision::double_precision), 12, 2);
}

TEST(FarScene, SameBitsWithNewton) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 8);
  scene.solver.newton_iterations = 4;
  expect_same_bits(scene, 8);
}

TEST(FarScene, SameBitsOfACurvedRestShape) {
  Scene scene = test::curled_sheet(Precision::single_precision, Bending::plate);
  expect_same_bits(scene, 10);
}

TEST(FarScene, SameBitsWithAdaptiveMeshes) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 6);
  scene.method = "adaptive";
  scene.adaptive.remeshing.size_min = 0.02;
  scene.adaptive.remeshing.size_max = 0.1;
  expect_same_bits(scene, 24);
}

TEST(FarScene, SameBitsInView) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 6);
  scene.method = "view";
  scene.adaptive.remeshing.size_min = 0.02;
  scene.adaptive.remeshing.size_max = 0.1;
  scene.camera.keys = {{0, {0.3, -1, 0.6}, {0, 0, 0}}, {1, {-0.3, -1, 0.6}, {0, 0, 0}}};
  expect_same_bits(scene, 16);
}

TEST(FarScene, SameBitsAsynchronously) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 6);
  scene.method = "asynchronous";
  scene.integrator = Integrator::implicit_euler;
  scene.obstacles[0].driven = DrivenBody{{0.01, 0, 0}, {0, 1, 0}, 0.01, 0.005, 0};
  snap(scene.obstacles[0].driven->origin);
  Pin pin;
  pin.vertices = {0};
  pin.motion = {{0, {}}, {0.1, {{0.01, 0, 0.01}, {0, 0, 1}, 0, 1}}};
  scene.pins = {pin};
  expect_same_bits(scene, 8);
}

TEST(FarScene, SameLevelsOfTimeParallelRuns) {
  Scene scene = snapped(test::sheet_on_sphere(Precision::single_precision, 8));
  scene.method = "time_parallel";
  const TimeParallelScene near(scene, 2), far(moved(scene, offset), 2);
  EXPECT_EQ(far.fine().origin, offset);
  EXPECT_EQ(far.coarse().scene.origin, offset);
  EXPECT_EQ(far.fine().cloths[0].mesh.positions, near.fine().cloths[0].mesh.positions);
  EXPECT_EQ(far.coarse().scene.cloths[0].mesh.positions,
            near.coarse().scene.cloths[0].mesh.positions);
  Simulation a(near.coarse().scene, host_devices(1)), b(far.coarse().scene, host_devices(1));
  EXPECT_EQ(b.origin(), offset);
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

TEST(FarScene, StartsWithinARoundingWhereTheOffsetIsNotExact) {
  const Vec3<double> uneven{300000.1, -12345.678, 1e6 / 3};
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const Scene scene = everything(precision);
    const Simulation near(scene, host_devices(1));
    const Simulation far(moved(scene, uneven), host_devices(1));
    // Coordinates of up to 0.2 m about an origin that is at most four sizes of 0.4 m from them.
    const double last_place = precision == Precision::single_precision ? 0x1p-23 : 0x1p-34;
    const Frame here = near.local_frame(), there = far.local_frame();
    const Vec3<double> shift = uneven - far.origin();
    EXPECT_LE(length(shift), 4 * 0.4 * std::sqrt(3));
    for (std::size_t v = 0; v < here.cloth_positions[0].size(); ++v)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(there.cloth_positions[0][v][k], here.cloth_positions[0][v][k] + shift[k],
                    last_place);
    for (std::size_t v = 0; v < here.obstacle_positions[0].size(); ++v)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(there.obstacle_positions[0][v][k], here.obstacle_positions[0][v][k] + shift[k],
                    last_place);
  }
}

TEST(FarScene, ResumesToTheSameBits) {
  const ScratchFolder folder;
  for (const std::string method : {"implicit", "adaptive"}) {
    Scene scene = method == "implicit" ? everything(Precision::single_precision)
                                       : test::sheet_on_sphere(Precision::double_precision, 6);
    scene.method = method;
    scene = moved(scene, {300000.1, 0, 0});
    const auto file = folder.path() / (method + ".weft");
    Simulation whole(scene, host_devices(1));
    for (int k = 0; k < 10; ++k) ASSERT_EQ(whole.step().failure, Failure::none);
    whole.save(file);
    Simulation resumed(scene, host_devices(1));
    resumed.resume(file);
    EXPECT_EQ(resumed.origin(), whole.origin());
    for (int k = 0; k < 8; ++k) {
      ASSERT_EQ(whole.step().failure, Failure::none);
      ASSERT_EQ(resumed.step().failure, Failure::none);
      ASSERT_EQ(whole.state_hash(), resumed.state_hash()) << method << " " << k;
    }
  }
}

TEST(FarScene, ACheckpointBringsItsOrigin) {
  const ScratchFolder folder;
  const auto file = folder.path() / "a.weft";
  const Scene scene = snapped(everything(Precision::double_precision));
  Simulation near(scene, host_devices(1));
  for (int k = 0; k < 4; ++k) ASSERT_EQ(near.step().failure, Failure::none);
  near.save(file);
  Simulation far(moved(scene, offset), host_devices(1));
  EXPECT_THROW(far.resume(file), SceneError) << "its cloth starts elsewhere";
  EXPECT_FALSE(far.resume(file, SceneChanges::allow).empty());
  EXPECT_EQ(far.origin(), zero);
  EXPECT_EQ(far.state_hash(), near.state_hash());
  EXPECT_EQ(far.frame().cloth_positions, near.frame().cloth_positions);
}

TEST(FarScene, PositionsMayBeGivenRelativeToAnOrigin) {
  Scene scene = snapped(test::sheet_on_sphere(Precision::single_precision, 6));
  Simulation near(scene, host_devices(1));
  scene.origin = Vec3<double>{0x1p40, 0, 0};
  Simulation given(scene, host_devices(1));
  EXPECT_EQ(given.origin(), *scene.origin);
  EXPECT_EQ(given.state_hash(), near.state_hash());
  EXPECT_EQ(given.local_frame().cloth_positions, near.frame().cloth_positions);
  EXPECT_EQ(given.frame().cloth_positions[0][0][0], near.frame().cloth_positions[0][0][0] + 0x1p40);
}

TEST(FarScene, FailuresAreReportedWhereTheyAre) {
  Scene scene = snapped(test::folded_napkin(Precision::single_precision));
  scene.pins[1].motion = {{0, {}}, {0.05, {{-0.2, 0, 0.2}}}, {0.1, {{-0.6, 0, -0.1}}}};
  scene.obstacles.resize(1);
  scene.obstacles[0].name = "box";
  scene.obstacles[0].mesh = make_box({0.8, 0.8, 0.1}, {2, 2, 1});
  scene.obstacles[0].transform.translate = {0, 0, -0.0625};
  Simulation near(scene, host_devices(1)), far(moved(scene, offset), host_devices(1));
  StepReport here, there;
  for (int k = 0; k < 20 && here.failure == Failure::none; ++k) {
    here = near.step();
    there = far.step();
    ASSERT_EQ(here.failure, there.failure);
  }
  ASSERT_NE(here.failure, Failure::none);
  ASSERT_TRUE(here.failure_place);
  EXPECT_EQ(*there.failure_place, *here.failure_place + offset);
}

}  // namespace
}  // namespace weft
