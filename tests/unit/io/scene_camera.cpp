#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include "host/io/scene/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr double degree = std::numbers::pi / 180;

class SceneCameraFile : public DirectoryTest {
 protected:
  /// @param camera value of the key
  std::filesystem::path put(const std::string& camera) const {
    return DirectoryTest::put("scene.json",
                              R"({"materials": {"cotton": {}}, "cloths": [{"material": "cotton",
        "grid": {"size": [1, 1], "cells": [2, 2]}}], "camera": )" +
                                  camera + "}");
  }
};

TEST_F(SceneCameraFile, IsReadInRadiansAndResolvesToItself) {
  const auto path = put(R"({"resolution": [640, 360], "keys": [
      {"position": [2, 0, 1], "look_at": [0, 0, 0.5]},
      {"time": 1.5, "position": [0, 2, 1], "look_at": [0, 0, 0], "up": [1, 0, 0],
       "field_of_view": 60, "jump": true}]})");
  const SceneFile file = read_scene_file(path);
  const Camera& camera = file.scene.camera;
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 360);
  ASSERT_EQ(camera.keys.size(), 2u);
  EXPECT_EQ(camera.keys[0].time, 0);
  EXPECT_EQ(camera.keys[0].look_at, (Vec3<double>{0, 0, 0.5}));
  EXPECT_EQ(camera.keys[0].up, (Vec3<double>{0, 0, 1}));
  EXPECT_NEAR(camera.keys[0].field_of_view, 40 * degree, 1e-15);
  EXPECT_FALSE(camera.keys[0].jump);
  EXPECT_EQ(camera.keys[1].time, 1.5);
  EXPECT_EQ(camera.keys[1].position, (Vec3<double>{0, 2, 1}));
  EXPECT_EQ(camera.keys[1].up, (Vec3<double>{1, 0, 0}));
  EXPECT_NEAR(camera.keys[1].field_of_view, 60 * degree, 1e-15);
  EXPECT_TRUE(camera.keys[1].jump);
  std::ofstream(path) << file.resolved.dump();
  EXPECT_EQ(resolved_scene_json(path), file.resolved);
}

TEST_F(SceneCameraFile, WithoutKeysThereIsNone) {
  const Camera camera = read_scene(put("{}")).camera;
  EXPECT_TRUE(camera.keys.empty());
  EXPECT_EQ(camera.width, Camera{}.width);
  EXPECT_EQ(camera.height, Camera{}.height);
}

TEST_F(SceneCameraFile, WithTheMethodViewOneThatFramesTheSceneIsWrittenDown) {
  const auto path = put(R"({"resolution": [320, 240]})");
  const SceneFile file = read_scene_file(path, {"method.type=view"});
  const Camera& camera = file.scene.camera;
  ASSERT_EQ(camera.keys.size(), 1u);
  const CameraKey& key = camera.keys[0];
  EXPECT_GT(length(key.position), 0.7);
  EXPECT_GT(key.position[2], 0.1) << "from above";
  // All corners of the square are in the picture, and fill most of it one way.
  const Vec3<double> forward = key.look_at - key.position;
  double most = 0;
  for (const Vec3<double>& x : file.scene.cloths[0].mesh.positions) {
    const Vec3<double> d = x - key.position;
    const double along = dot(d, forward) / length(forward);
    const double off = length(d - (along / length(forward)) * forward) / along;
    most = std::max(most, off / std::tan(key.field_of_view / 2));
  }
  EXPECT_GT(most, 0.6);
  EXPECT_LT(most, 5.0 / 3);
  std::ofstream(path) << file.resolved.dump();
  EXPECT_EQ(resolved_scene_json(path), file.resolved);
}

TEST_F(SceneCameraFile, TakesTheLimitsOfTheFieldOfView) {
  for (const char* angle : {"1", "150"})
    EXPECT_NO_THROW(read_scene(put(std::string(R"({"keys": [{"position": [2, 0, 1],
        "look_at": [0, 0, 0], "field_of_view": )") +
                                   angle + "}]}")));
  for (const char* angle : {"0.5", "151", "-40"})
    EXPECT_THROW(read_scene(put(std::string(R"({"keys": [{"position": [2, 0, 1],
        "look_at": [0, 0, 0], "field_of_view": )") +
                                angle + "}]}")),
                 SceneError);
}

TEST_F(SceneCameraFile, RefusesAViewThatIsNoneForAnyReason) {
  for (const char* key : {R"("look_at": [1, 1, 1], "position": [1, 1, 1])",
                          R"("look_at": [0, 0, 0], "position": [1, 1, 1], "up": [0, 0, 0])",
                          R"("look_at": [0, 0, 0], "position": [1, 1, 1], "up": [-2, -2, -2])",
                          R"("look_at": [0, 0, 0], "position": [1e200, 1, 1])"})
    EXPECT_THROW(read_scene(put(std::string(R"({"keys": [{)") + key + "}]}")), SceneError) << key;
}

}  // namespace
}  // namespace weft::io
