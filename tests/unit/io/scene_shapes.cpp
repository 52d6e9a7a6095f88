#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/io/scene/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

/// Panels, discs with holes, surfaces of revolution; edges by name; pins that follow an obstacle.
namespace weft::io {
namespace {

using nlohmann::json;

class SceneShapesTest : public DirectoryTest {
 protected:
  json base() const {
    return json::parse(R"({
      "materials": {"cotton": {}},
      "cloths": [
        {"name": "panel", "material": "cotton",
         "panel": {"outline": [[0, 0.4], [0.5, -0.2, 0.3], [1, 0.2]], "cells": [4, 10]}},
        {"name": "skirt", "material": "cotton", "transform": {"translate": [0, 0, 5]},
         "disc": {"inner_radius": 0.1, "radius": 0.5, "cells": 4}},
        {"name": "tube", "material": "cotton", "transform": {"translate": [0, 0, 9]},
         "cylinder": {"radius": 0.1, "height": 0.3, "cells": [5, 3]}}
      ],
      "obstacles": [{"name": "ring", "transform": {"translate": [0, 0, -5]},
        "revolution": {"profile": [[0.3, 0], [0.4, 0], [0.4, 0.1]], "closed": true, "edge": 0.05}}]
    })");
  }
  Scene read(const json& scene, const std::vector<std::string>& overrides = {}) const {
    return read_scene(put("scene.json", scene.dump()), overrides);
  }
  std::vector<Index> pinned(const json& pin) const {
    json scene = base();
    scene["pins"] = json::array({pin});
    return read(scene).pins.at(0).vertices;
  }
  std::string refusal(const json& scene) const {
    try {
      read(scene);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }
};

std::vector<Index> numbers(Index first, Index count, Index step = 1) {
  std::vector<Index> result;
  for (Index i = 0; i < count; ++i) result.push_back(first + i * step);
  return result;
}

TEST_F(SceneShapesTest, Meshes) {
  const Scene scene = read(base());
  EXPECT_EQ(scene.cloths[0].mesh.triangles.size(), 80u);
  EXPECT_NEAR(scene.cloths[0].mesh.positions[29][0], 0.3, 1e-15);  // right end of row 5
  EXPECT_EQ(scene.cloths[1].mesh.triangles.size(), 6u * (25u - 1u));
  EXPECT_EQ(scene.obstacles[0].mesh.triangles.size(), 2u * 50u * (2u + 2u + 3u));
}

TEST_F(SceneShapesTest, ResolutionGoesForAllOfThem) {
  json scene = base();
  scene["cloths"][0]["panel"].erase("cells");
  scene["cloths"][1]["disc"].erase("cells");
  scene["cloths"][2]["cylinder"].erase("cells");
  for (const int wanted : {1000, 8000}) {
    const Scene made = read(scene, {"triangles=" + std::to_string(wanted)});
    double count = 0;
    for (const Cloth& cloth : made.cloths)
      count += static_cast<double>(cloth.mesh.triangles.size());
    EXPECT_NEAR(count / wanted, 1, 0.08) << wanted;
  }
}

TEST_F(SceneShapesTest, ResolvedSceneReadsTheSame) {
  json scene = base();
  scene["cloths"][0]["panel"].erase("cells");
  scene["cloths"][1]["disc"].erase("cells");
  scene["obstacles"][0]["revolution"].erase("edge");
  scene["pins"] = json::array({{{"cloth", "skirt"}, {"edge", "inner"}, {"obstacle", "ring"}},
                               {{"cloth", "panel"}, {"edge", {{"name", "left"}, {"to", 0.3}}}}});
  const json resolved = resolved_scene_json(put("scene.json", scene.dump()), {});
  EXPECT_EQ(resolved["pins"][0]["obstacle"], "ring");
  EXPECT_EQ(resolved_scene_json(put("again.json", resolved.dump()), {}), resolved);
}

TEST_F(SceneShapesTest, RestShapes) {
  put("rest.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 1 0\nf 1 2 3\nf 2 4 3\n");
  put("cloth.obj",
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
      "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n");
  json scene = base();
  EXPECT_TRUE(read(scene).cloths[2].rest_positions.empty());
  scene["cloths"][2]["rest"] = "initial";
  scene["cloths"].push_back({{"name", "fold"},
                             {"material", "cotton"},
                             {"mesh", "cloth.obj"},
                             {"rest", "rest.obj"},
                             {"transform", {{"scale", 2}, {"translate", {0, 9, 0}}}},
                             {"copies", {{"count", 2}, {"translate", {0, 3, 0}}}}});
  const Scene made = read(scene);
  EXPECT_EQ(made.cloths[2].rest_positions.size(), 20u);
  for (std::size_t v = 0; v < 20; ++v)
    EXPECT_EQ(0, length(made.cloths[2].rest_positions[v] - made.cloths[2].mesh.positions[v]));
  for (const std::size_t copy : {3u, 4u}) {
    const auto& rest = made.cloths[copy].rest_positions;
    ASSERT_EQ(4u, rest.size());
    EXPECT_NEAR(2, length(rest[2] - rest[0]), 1e-15);
    EXPECT_NEAR(2 * std::sqrt(3.0), length(rest[3] - rest[2]), 1e-15);
  }
  const json resolved = resolved_scene_json(put("scene.json", scene.dump()), {});
  EXPECT_EQ("flat", resolved["cloths"][0]["rest"]);
  EXPECT_EQ("initial", resolved["cloths"][2]["rest"]);
  EXPECT_EQ(resolved_scene_json(put("again.json", resolved.dump()), {}), resolved);
}

TEST_F(SceneShapesTest, EdgesByName) {
  EXPECT_EQ(pinned({{"cloth", "panel"}, {"edge", "right"}}), numbers(4, 11, 5));
  EXPECT_EQ(pinned({{"cloth", "panel"}, {"edge", "top"}}), numbers(50, 5));
  EXPECT_EQ(pinned({{"cloth", "skirt"}, {"edge", "inner"}}), numbers(0, 6));
  EXPECT_EQ(pinned({{"cloth", "skirt"}, {"edge", "outer"}}), numbers(6 + 12 + 18 + 24, 30));
  EXPECT_EQ(pinned({{"cloth", "tube"}, {"edge", "bottom"}}), numbers(0, 5));
  EXPECT_EQ(pinned({{"cloth", "tube"}, {"edge", "top"}}), numbers(15, 5));
}

TEST_F(SceneShapesTest, PartsOfEdges) {
  // Rows of the panel's left side are as far apart as its outline is long over 5.
  const double row = std::sqrt(0.25 + 0.04) / 5;
  const auto left = [&](const json& part) { return pinned({{"cloth", "panel"}, {"edge", part}}); };
  EXPECT_EQ(left({{"name", "left"}}), numbers(0, 11, 5));
  EXPECT_EQ(left({{"name", "left"}, {"to", 3 * row}}), numbers(0, 4, 5));
  EXPECT_EQ(left({{"name", "left"}, {"from", 3 * row}, {"to", 5.1 * row}}), numbers(15, 3, 5));
  EXPECT_EQ(left({{"name", "top"}, {"from", 0.29}}), numbers(53, 2));
  json scene = base();
  scene["pins"] = json::array(
      {{{"cloth", "panel"}, {"edge", {{"name", "top"}, {"from", 0.11}, {"to", 0.12}}}}});
  EXPECT_NE(refusal(scene).find("pins[0].edge: "), std::string::npos) << refusal(scene);
}

TEST_F(SceneShapesTest, PinThatFollowsAnObstacle) {
  json scene = base();
  scene["pins"] = json::array({{{"cloth", "skirt"}, {"edge", "inner"}, {"obstacle", "ring"}},
                               {{"cloth", "tube"}, {"edge", "top"}}});
  const Scene made = read(scene);
  EXPECT_EQ(made.pins[0].obstacle, 0);
  EXPECT_EQ(made.pins[1].obstacle, -1);
}

TEST_F(SceneShapesTest, MissingTakeNamesThePackage) {
  json scene = base();
  scene["obstacles"][0].erase("revolution");
  scene["obstacles"][0]["capture"] = {{"file", "/usr/share/assimp/models/BVH/none.bvh"}};
  EXPECT_NE(refusal(scene).find("assimp-testmodels"), std::string::npos) << refusal(scene);
  scene["obstacles"][0]["capture"] = {{"file", "/nowhere/none.bvh"}};
  EXPECT_EQ(refusal(scene).find("assimp-testmodels"), std::string::npos);
}

TEST_F(SceneShapesTest, BodiesMayOverlapThemselvesAtTheStart) {
  json scene = base();
  scene["cloths"][1]["transform"] = {{"translate", {0, 0, 1.02}}};
  std::filesystem::copy_file(repository_root() / "scenes/walk.bvh", directory_ / "walk.bvh");
  scene["obstacles"][0] = {{"name", "body"}, {"units", "cm"}, {"capture", {{"file", "walk.bvh"}}}};
  scene["cloths"][0]["transform"] = {{"translate", {0, 0, 20}}};
  scene["cloths"][1]["disc"] = {{"inner_radius", 0.15}, {"radius", 0.3}, {"cells", 4}};
  EXPECT_EQ(refusal(scene), "");
}

TEST_F(SceneShapesTest, KeysSayHowTheyGoOn) {
  json scene = base();
  scene["obstacles"][0].erase("transform");
  scene["obstacles"][0]["motion"] = {
      {{"time", 0}, {"translate", {0, 0, -5}}, {"interpolation", "linear"}},
      {{"time", 1}, {"translate", {0, 0, -6}}},
      {{"time", 2}, {"translate", {0, 0, -6}}}};
  const Motion motion = read(scene).obstacles[0].motion;
  EXPECT_EQ(motion[0].interpolation, Interpolation::linear);
  EXPECT_EQ(motion[1].interpolation, Interpolation::cubic);
  EXPECT_EQ(transform_at(motion, 0.25).translate[2], -5.25);
}

}  // namespace
}  // namespace weft::io
