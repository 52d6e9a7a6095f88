#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/io/json/json_fields.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/model/model.hpp"
#include "host/scene/intersection_check.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

/// Obstacles that change their shape, as a scene file names them.
namespace weft::io {
namespace {

using nlohmann::json;

const std::string take = R"(HIERARCHY
ROOT Hips { OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine { OFFSET 0 40 0 CHANNELS 3 Zrotation Xrotation Yrotation
    End Site { OFFSET 0 60 0 } } }
MOTION
Frames: 3
Frame Time: 0.1
0 0 0 0 0 0  0 0 0
0 0 100 0 0 0  0 0 0
0 0 100 90 0 0  0 0 0
)";

class SceneBodiesTest : public DirectoryTest {
 protected:
  /// A scene with a small sheet far away and one obstacle.
  json with(const json& obstacle) const {
    json scene = json::parse(R"({
      "materials": {"cotton": {}},
      "cloths": [{"grid": {"size": [1, 1], "cells": [4, 4]}, "material": "cotton",
                  "transform": {"translate": [0, 0, 30]}}]
    })");
    scene["obstacles"] = json::array({obstacle});
    return scene;
  }
  Scene read(const json& obstacle) const {
    return read_scene(put("scene.json", with(obstacle).dump()));
  }
  std::string refusal(const json& obstacle) const {
    try {
      read(obstacle);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }
};

double top(const std::vector<Vec3<double>>& points) {
  double high = -1e9;
  for (const Vec3<double>& x : points) high = std::max(high, x[2]);
  return high;
}

TEST_F(SceneBodiesTest, CaptureStandsAsTallAsAskedAndMoves) {
  put("take.bvh", take);
  const Scene scene = read({{"capture", {{"file", "take.bvh"}, {"height", 2}, {"start_time", 1}}},
                            {"transform", {{"translate", {0, 0, 5}}}}});
  const Obstacle& body = scene.obstacles.at(0);
  ASSERT_TRUE(body.deformation);
  // The end site is on the skin, so the body is as tall above its hips as the skeleton.
  EXPECT_NEAR(top(body.mesh.positions), 2, 1e-12);
  const Model model = make_model(scene);
  std::vector<Vec3<double>> placed;
  place_obstacles(scene, model, 0, placed);
  EXPECT_NEAR(top(placed), 7, 1e-12);
  place_obstacles(scene, model, 1.1, placed);  // the second frame: 100 units of 2 cm towards -y
  double nearest = 1e9;
  for (const Vec3<double>& x : placed) nearest = std::min(nearest, std::fabs(x[1] + 2));
  EXPECT_LT(nearest, 0.05);
  EXPECT_NEAR(top(placed), 7, 1e-12);
  place_obstacles(scene, model, 9, placed);  // lies on its side
  EXPECT_LT(top(placed), 5.5);
}

TEST_F(SceneBodiesTest, CaptureRadiiComeFromNumberTableOrNames) {
  put("take.bvh", take);
  const auto width = [&](json radius) {
    json body{{"capture", {{"file", "take.bvh"}}}, {"units", "cm"}};
    if (!radius.is_null()) body["capture"]["radius"] = std::move(radius);
    double widest = 0;
    for (const Vec3<double>& x : read(body).obstacles.at(0).mesh.positions)
      widest = std::max(widest, std::hypot(x[0], x[1]));
    return widest;
  };
  EXPECT_NEAR(width(0.05), 0.05, 1e-12);
  EXPECT_NEAR(width({{"Hips", 0.03}, {"Spine", 0.02}}), 0.03, 1e-12);
  EXPECT_NEAR(width(nullptr), 0.07, 1e-12);  // hips and spine of a body 1 m tall
  EXPECT_NE(refusal({{"capture", {{"file", "take.bvh"}, {"radius", {{"Spline", 1}}}}}})
                .find("did you mean \"Spine\"?"),
            std::string::npos);
}

TEST_F(SceneBodiesTest, CaptureKeysAreChecked) {
  put("take.bvh", take);
  const auto with_key = [&](const char* key, json value) {
    json body{{"capture", {{"file", "take.bvh"}}}, {"units", "cm"}};
    body["capture"][key] = std::move(value);
    return refusal(body);
  };
  EXPECT_NE(with_key("height", 2).find("capture.height: 2"), std::string::npos);
  EXPECT_NE(with_key("last", 3).find("an integer from 0 to 2"), std::string::npos);
  EXPECT_NE(with_key("radius", 0).find("capture.radius: 0"), std::string::npos);
  EXPECT_NE(with_key("speed", 0).find("capture.speed: 0"), std::string::npos);
  EXPECT_NE(with_key("up", "z").find("capture.up: no longer a key: up of the obstacle"),
            std::string::npos);
  EXPECT_NE(with_key("last_frame", 1).find("its new name, \"last\""), std::string::npos);
  EXPECT_NE(refusal({{"capture", {{"file", "take.bvh"}}}, {"up", "x"}}).find("obstacles[0].up: "),
            std::string::npos);
  EXPECT_EQ(with_key("loop", true), "");
}

TEST_F(SceneBodiesTest, SequenceIsExactAtItsFramesUnderAMotion) {
  for (int f = 0; f < 3; ++f) {
    Mesh mesh = make_icosphere(1 + 0.5 * f, 1);
    write_obj(directory_ / ("body_" + std::to_string(f) + ".obj"), {{"body", mesh}});
  }
  const json key{{"time", 1}, {"translate", {0, 0, 4}}};
  const Scene scene = read({{"sequence", {{"files", "body_%d.obj"}, {"frame_rate", 10}}},
                            {"motion", json::array({json{{"time", 0}}, key})}});
  const Model model = make_model(scene);
  std::vector<Vec3<double>> placed;
  for (int f = 0; f < 3; ++f) {
    place_obstacles(scene, model, f / 10.0, placed);
    const Transform there = transform_at(scene.obstacles[0].motion, f / 10.0);
    const Mesh mesh = make_icosphere(1 + 0.5 * f, 1);
    for (std::size_t v = 0; v < placed.size(); ++v)
      EXPECT_LT(length(placed[v] - apply(there, mesh.positions[v])), 2e-7);
  }
}

const std::string usd_body = R"(#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Y"
    timeCodesPerSecond = 10
)
def Xform "body"
{
    matrix4d xformOp:transform = ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 100, 0, 1) )
    uniform token[] xformOpOrder = ["xformOp:transform"]
    def Mesh "skin"
    {
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = [0, 1, 2, 2, 1, 3]
        point3f[] points.timeSamples = {
            5: [(0, 0, 0), (100, 0, 0), (0, 0, 100), (100, 0, 100)],
            10: [(0, 50, 0), (100, 50, 0), (0, 50, 100), (100, 50, 100)],
        }
    }
}
)";

TEST_F(SceneBodiesTest, AnimatedUsdSaysItsOwnUnitsAxesAndRate) {
  put("body.usda", usd_body);
  const Scene scene = read({{"sequence", {{"files", "body.usda"}, {"interpolation", "linear"}}}});
  const Obstacle& body = scene.obstacles.at(0);
  ASSERT_TRUE(body.deformation);
  std::vector<Vec3<double>> points(body.mesh.positions.size());
  body.deformation->positions(0.25, Span<Vec3<double>>(points.data(), points.size()));
  ASSERT_EQ(points.size(), 4u);
  // Halfway through five of ten time codes a second; centimetres, y up.
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(points[3][k], (Vec3<double>{1, -1, 1.25}[k]), 1e-6) << k;
  EXPECT_NE(
      refusal({{"sequence", {{"files", "body.usda"}}}, {"up", "y"}}).find("obstacles[0].up: "),
      std::string::npos);
  EXPECT_NE(refusal({{"sequence", {{"files", "body.usda"}}}, {"units", "m"}})
                .find("obstacles[0].units: "),
            std::string::npos);
  EXPECT_NE(refusal({{"sequence", {{"files", "body.usda"}, {"last", 2}}}}).find("which has 2"),
            std::string::npos);
  put("bones.usda",
      "#usda 1.0\ndef SkelRoot \"r\" {\ndef Mesh \"m\" {\nint[] faceVertexCounts = [3]\nint[] "
      "faceVertexIndices = [0, 1, 2]\npoint3f[] points = [(0,0,0), (1,0,0), (0,1,0)]\n}\n}\n");
  EXPECT_NE(refusal({{"sequence", {{"files", "bones.usda"}}}}).find("moved by a skeleton"),
            std::string::npos);
  EXPECT_NE(read({{"mesh", "bones.usda"}}).warnings.at(0).find("skeleton is passed over"),
            std::string::npos);
  const Scene still = read({{"mesh", "body.usda"}});
  EXPECT_NE(still.warnings.at(0).find("only the first of its 2 time codes"), std::string::npos);
  EXPECT_NEAR(still.obstacles[0].mesh.positions[3][2], 1, 1e-12);
}

TEST_F(SceneBodiesTest, ResolvedSceneReadsTheSame) {
  put("take.bvh", take);
  write_obj(directory_ / "body_3.obj", {{"body", make_icosphere(1, 1)}});
  write_obj(directory_ / "body_4.obj", {{"body", make_icosphere(2, 1)}});
  const std::vector<json> obstacles{
      {{"capture", {{"file", "take.bvh"}, {"radius", {{"Spine", 0.05}}}}}},
      {{"sequence", {{"files", "body_%d.obj"}, {"first", 3}}}},
      {{"capsule", {{"radius", 0.2}, {"length", 1}}}}};
  for (const json& obstacle : obstacles) {
    const auto path = put("scene.json", with(obstacle).dump());
    const json resolved = resolved_scene_json(path);
    const auto again = put("resolved.json", resolved.dump());
    EXPECT_EQ(resolved_scene_json(again), resolved) << obstacle;
    const Mesh a = read_scene(path).obstacles.at(0).mesh;
    const Mesh b = read_scene(again).obstacles.at(0).mesh;
    ASSERT_EQ(a.positions.size(), b.positions.size());
    for (std::size_t v = 0; v < a.positions.size(); ++v)
      EXPECT_TRUE(a.positions[v] == b.positions[v]);
  }
}

TEST_F(SceneBodiesTest, ClothInsideABodyIsRefused) {
  put("take.bvh", take);
  json scene = with({{"capture", {{"file", "take.bvh"}, {"radius", 0.2}}},
                     {"units", "cm"},
                     {"transform", {{"translate", {0, 0, 29.7}}}}});
  scene["cloths"][0]["grid"]["size"] = {0.05, 0.05};
  EXPECT_THROW(refuse_intersecting_start(read_scene(put("scene.json", scene.dump()))), SceneError);
  scene["obstacles"][0]["transform"]["translate"] = {0, 0, 25};
  EXPECT_NO_THROW(refuse_intersecting_start(read_scene(put("scene.json", scene.dump()))));
}

TEST_F(SceneBodiesTest, DiscAndCylinderShareTheTriangles) {
  json scene = with({{"sphere", {{"radius", 0.1}}}});
  scene["triangles"] = 10000;
  scene["cloths"] = json::array({json{{"disc", {{"radius", 0.5}}},
                                      {"material", "cotton"},
                                      {"transform", {{"translate", {0, 0, 2}}}}},
                                 json{{"cylinder", {{"radius", 0.3}, {"height", 0.7}}},
                                      {"material", "cotton"},
                                      {"transform", {{"translate", {0, 0, 5}}}}}});
  const auto path = put("scene.json", scene.dump());
  const Scene read = read_scene(path);
  const double disc = static_cast<double>(read.cloths[0].mesh.triangles.size());
  const double tube = static_cast<double>(read.cloths[1].mesh.triangles.size());
  EXPECT_NEAR(disc + tube, 10000, 500);
  // Areas pi / 4 and 0.42 pi.
  EXPECT_NEAR(disc / tube, 0.25 / 0.42, 0.05);
  const json resolved = resolved_scene_json(path);
  EXPECT_TRUE(resolved["cloths"][0]["disc"]["cells"].is_number_integer());
  EXPECT_EQ(resolved["cloths"][1]["cylinder"]["cells"].size(), 2u);
  EXPECT_EQ(resolved_scene_json(put("resolved.json", resolved.dump())), resolved);
}

}  // namespace
}  // namespace weft::io
