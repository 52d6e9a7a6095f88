#include <gtest/gtest.h>

#include <random>
#include <string>

#include "host/geometry/nearest_pairs.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/scene/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using SceneSeams = DirectoryTest;
using nlohmann::json;
using Indices = std::vector<Index>;

/// Two panels of 2 x 2 cells, front to front, and seams between them.
json garment(const std::string& seams) {
  json scene = json::parse(R"({
    "materials": {"cotton": {}},
    "contact": {"thickness": 0.002},
    "cloths": [
      {"name": "front", "material": "cotton", "grid": {"size": [1, 1], "cells": [2, 2]}},
      {"name": "back", "material": "cotton", "grid": {"size": [1, 1], "cells": [2, 2]},
       "transform": {"translate": [0, 0, -0.1], "rotate": [180, 0, 1, 0]}}
    ]})");
  scene["seams"] = json::parse(seams);
  return scene;
}

void expect_same(const Seam& a, const Seam& b) {
  for (int side = 0; side < 2; ++side) {
    EXPECT_EQ(a.cloths[side], b.cloths[side]) << side;
    EXPECT_EQ(a.vertices[side], b.vertices[side]) << side;
  }
  EXPECT_EQ(a.stiffness, b.stiffness);
  EXPECT_EQ(a.start_time, b.start_time);
  EXPECT_EQ(a.ramp_time, b.ramp_time);
  EXPECT_EQ(a.weld_distance, b.weld_distance);
  EXPECT_EQ(a.may_stay_open, b.may_stay_open);
}

TEST_F(SceneSeams, DefaultsAreThoseOfTheStruct) {
  const json scene = garment(R"([{"cloths": ["front", "back"], "pairs": [[0, 2]]}])");
  const Scene read = read_scene(put("garment.json", scene.dump()));
  ASSERT_EQ(read.seams.size(), 1u);
  const Seam& seam = read.seams[0];
  EXPECT_EQ(seam.cloths[0], 0);
  EXPECT_EQ(seam.cloths[1], 1);
  EXPECT_EQ(seam.stiffness, Seam{}.stiffness);
  EXPECT_EQ(seam.start_time, Seam{}.start_time);
  EXPECT_EQ(seam.ramp_time, Seam{}.ramp_time);
  EXPECT_EQ(seam.weld_distance, 0.002);  // the thickness
  EXPECT_FALSE(seam.may_stay_open);
  EXPECT_EQ(read.refinement.when, Refinement::When::never);
  EXPECT_EQ(read.refinement.levels, Refinement{}.levels);
}

TEST_F(SceneSeams, PairsChainsAndSelectionsSayTheSame) {
  const auto seam_of = [&](const char* text) {
    const Scene scene = read_scene(put("garment.json", garment(text).dump()));
    EXPECT_EQ(scene.seams.size(), 1u);
    return scene.seams.at(0);
  };
  const Seam pairs =
      seam_of(R"([{"cloths": ["front", "back"], "pairs": [[0, 2], [3, 5], [6, 8]]}])");
  EXPECT_EQ(pairs.vertices[0], (Indices{0, 3, 6}));
  EXPECT_EQ(pairs.vertices[1], (Indices{2, 5, 8}));
  expect_same(pairs,
              seam_of(R"([{"cloths": ["front", "back"], "chains": [[0, 3, 6], [2, 5, 8]]}])"));
  expect_same(pairs, seam_of(R"([{"between": [{"cloth": "front", "edge": "left"},
                                              {"cloth": "back", "edge": "right"}]}])"));
  // In whichever order the vertices are named.
  expect_same(pairs, seam_of(R"([{"between": [{"cloth": "front", "vertices": [6, 0, 3]},
                           {"cloth": "back", "box": {"min": [-0.6, -1, -1], "max": [-0.4, 1, 1]}}]}])"));
}

TEST_F(SceneSeams, SewsAClothToItself) {
  const json scene = json::parse(R"({
    "materials": {"cotton": {}},
    "cloths": [{"name": "tube", "material": "cotton", "grid": {"size": [1, 1], "cells": [4, 4]}}],
    "seams": [{"cloths": ["tube", "tube"], "chains": [[0, 5, 10, 15, 20], [4, 9, 14, 19, 24]],
               "stiffness": 20, "start_time": 0.1, "ramp_time": 0, "weld_distance": 0}]})");
  const Scene read = read_scene(put("tube.json", scene.dump()));
  ASSERT_EQ(read.seams.size(), 1u);
  EXPECT_EQ(read.seams[0].cloths[0], 0);
  EXPECT_EQ(read.seams[0].cloths[1], 0);
  EXPECT_EQ(read.seams[0].stiffness, 20);
  EXPECT_EQ(read.seams[0].start_time, 0.1);
  EXPECT_EQ(read.seams[0].ramp_time, 0);
  EXPECT_EQ(read.seams[0].weld_distance, 0);
}

TEST_F(SceneSeams, SewsCopiesOneByOne) {
  json scene = garment(R"([{"cloths": ["front", "back"], "pairs": [[0, 2]]},
                           {"between": [{"cloth": "front", "edge": "right"},
                                        {"cloth": "back", "edge": "left"}]}])");
  for (json& cloth : scene["cloths"]) cloth["copies"] = {{"count", 3}, {"translate", {0, 0, 1}}};
  const Scene read = read_scene(put("copies.json", scene.dump()));
  ASSERT_EQ(read.cloths.size(), 6u);
  ASSERT_EQ(read.seams.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(read.seams[k].cloths[0], static_cast<Index>(k % 3)) << k;
    EXPECT_EQ(read.seams[k].cloths[1], static_cast<Index>(3 + k % 3)) << k;
    EXPECT_EQ(read.seams[k].vertices[0], k < 3 ? Indices{0} : (Indices{2, 5, 8})) << k;
    EXPECT_EQ(read.seams[k].vertices[1], k < 3 ? Indices{2} : (Indices{0, 3, 6})) << k;
  }
}

TEST_F(SceneSeams, ResolvedSceneReadsBackTheSame) {
  json scene = garment(R"([
      {"between": [{"cloth": "front", "edge": "left"}, {"cloth": "back", "edge": "right"}],
       "stiffness": 77, "ramp_time": 0.25},
      {"cloths": ["front", "back"], "pairs": [[2, 0], [5, 3]], "weld_distance": 0.003,
       "may_stay_open": true},
      {"cloths": ["back", "front"], "chains": [[6], [8]]}])");
  scene["refine"] = {{"when", "sewn"}, {"levels", 3}};
  const SceneFile first = read_scene_file(put("garment.json", scene.dump()));
  EXPECT_EQ(first.resolved.at("seams").at(0).at("weld_distance"), 0.002);
  EXPECT_EQ(first.resolved.at("refine").at("levels"), 3);
  const SceneFile second = read_scene_file(put("resolved.json", first.resolved.dump()));
  EXPECT_EQ(second.resolved, first.resolved);
  ASSERT_EQ(second.scene.seams.size(), 3u);
  EXPECT_EQ(second.scene.seams[0].stiffness, 77);
  EXPECT_FALSE(second.scene.seams[1].stiffness);
  for (std::size_t k = 0; k < 3; ++k) expect_same(first.scene.seams[k], second.scene.seams[k]);
  EXPECT_EQ(second.scene.refinement.when, Refinement::When::sewn);
  EXPECT_EQ(second.scene.refinement.levels, 3);
}

TEST_F(SceneSeams, ResolvedSceneOfNoSeamsSaysSo) {
  const json resolved = resolved_scene_json(put("none.json", garment("[]").dump()));
  EXPECT_EQ(resolved.at("seams"), json::array());
  EXPECT_EQ(resolved.at("refine"), (json{{"when", "never"}, {"levels", 1}}));
  read_scene(put("again.json", resolved.dump()));
}

TEST_F(SceneSeams, SelectionsLeaveOutPairsThatAreSewnAlready) {
  // A cushion: each corner belongs to two edges.
  const char* all = R"([
      {"between": [{"cloth": "front", "edge": "left"}, {"cloth": "back", "edge": "right"}]},
      {"between": [{"cloth": "back", "edge": "left"}, {"cloth": "front", "edge": "right"}]},
      {"between": [{"cloth": "front", "edge": "top"}, {"cloth": "back", "edge": "top"}]},
      {"between": [{"cloth": "back", "edge": "bottom"}, {"cloth": "front", "edge": "bottom"}]}])";
  const Scene scene = read_scene(put("cushion.json", garment(all).dump()));
  ASSERT_EQ(scene.seams.size(), 4u);
  EXPECT_EQ(scene.seams[0].vertices[0], (Indices{0, 3, 6}));
  EXPECT_EQ(scene.seams[1].vertices[0], (Indices{0, 3, 6}));
  EXPECT_EQ(scene.seams[2].vertices[0], Indices{7});
  EXPECT_EQ(scene.seams[2].vertices[1], Indices{7});
  EXPECT_EQ(scene.seams[3].vertices[0], Indices{1});
  json twice = garment(all);
  twice["seams"].push_back(twice["seams"][0]);
  EXPECT_THROW(read_scene(put("twice.json", twice.dump())), SceneError);
}

/// All pairs of a seam start at one height, since both sides are as long.
void expect_level(const Scene& scene, const Seam& seam) {
  for (std::size_t k = 0; k < seam.vertices[0].size(); ++k) {
    const auto place = [&](int side) {
      return scene.cloths[static_cast<std::size_t>(seam.cloths[side])]
          .mesh.positions[static_cast<std::size_t>(seam.vertices[side][k])];
    };
    EXPECT_NEAR(place(0)[1], place(1)[1], 1e-12) << k;
  }
}

TEST_F(SceneSeams, VerticesWithoutAPartnerGetOne) {
  json scene = garment(R"([{"between": [{"cloth": "front", "edge": "left"},
                                        {"cloth": "back", "edge": "right"}]}])");
  scene["cloths"][1]["grid"]["cells"] = {2, 4};
  scene["pins"] = json::parse(R"([{"cloth": "front", "edge": "left"}])");
  const Scene read = read_scene(put("garment.json", scene.dump()));
  ASSERT_EQ(read.seams.size(), 1u);
  // 0, 3 and 6 have partners; the two between them are new.
  EXPECT_EQ(read.cloths[0].mesh.positions.size(), 11u);
  EXPECT_EQ(read.cloths[0].mesh.triangles.size(), 10u);
  EXPECT_EQ(read.seams[0].vertices[0], (Indices{0, 9, 3, 10, 6}));
  EXPECT_EQ(read.seams[0].vertices[1], (Indices{2, 5, 8, 11, 14}));
  expect_level(read, read.seams[0]);
  // What lies between vertices that are held is held.
  EXPECT_EQ(read.pins[0].vertices, (Indices{0, 3, 6, 9, 10}));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("cloth \"front\" gets 2 vertices more"), std::string::npos);
}

TEST_F(SceneSeams, ChainsOfUnequalLengthsRunAsGiven) {
  json scene =
      garment(R"([{"cloths": ["front", "back"], "chains": [[6, 3, 0], [14, 11, 8, 5, 2]]}])");
  scene["cloths"][1]["grid"]["cells"] = {2, 4};
  const Scene read = read_scene(put("garment.json", scene.dump()));
  EXPECT_EQ(read.seams[0].vertices[0], (Indices{6, 9, 3, 10, 0}));
  EXPECT_EQ(read.seams[0].vertices[1], (Indices{14, 11, 8, 5, 2}));
}

/// The second seam finds the vertices that the first one has put on the edge.
TEST_F(SceneSeams, EdgesHaveTheVerticesOfEarlierSeams) {
  json scene = garment(R"([
      {"between": [{"cloth": "front", "edge": "left"}, {"cloth": "back", "edge": "right"}]},
      {"between": [{"cloth": "third", "edge": "right"}, {"cloth": "front", "edge": "left"}]}])");
  scene["cloths"][1]["grid"]["cells"] = {2, 4};
  scene["cloths"].push_back(scene["cloths"][1]);
  scene["cloths"][2]["name"] = "third";
  scene["cloths"][2]["grid"]["cells"] = {2, 2};
  scene["cloths"][2]["transform"]["translate"] = {0, 0, -0.2};
  const Scene read = read_scene(put("garment.json", scene.dump()));
  ASSERT_EQ(read.seams.size(), 2u);
  EXPECT_EQ(read.seams[1].vertices[0].size(), 5u);
  EXPECT_EQ(read.cloths[2].mesh.positions.size(), 11u);
  expect_level(read, read.seams[1]);
}

/// A seam that ends on an edge: both parts of the edge meet in one vertex.
TEST_F(SceneSeams, PartsOfAnEdgeMeetInOneVertex) {
  json scene = garment(R"([
      {"between": [{"cloth": "front", "edge": {"name": "top", "to": 0.62}},
                   {"cloth": "low", "edge": "bottom"}]},
      {"between": [{"cloth": "front", "edge": {"name": "top", "from": 0.62}},
                   {"cloth": "high", "edge": "bottom"}]}])");
  for (const char* name : {"low", "high"}) {
    scene["cloths"].push_back(scene["cloths"][0]);
    scene["cloths"].back()["name"] = name;
    scene["cloths"].back()["grid"] = {{"size", {0.5, 1}}, {"cells", {3, 2}}};
    scene["cloths"].back()["transform"]["translate"] = {*name == 'l' ? -0.25 : 0.25, 1, 0};
  }
  const Scene read = read_scene(put("garment.json", scene.dump()));
  ASSERT_EQ(read.seams.size(), 2u);
  EXPECT_EQ(read.seams[0].vertices[0].back(), 7);
  EXPECT_EQ(read.seams[1].vertices[0].front(), 7);
  EXPECT_EQ(read.seams[0].vertices[1].size(), 4u);
}

/// Around a closed edge an open one is sewn so that its ends meet.
TEST_F(SceneSeams, OpenEdgesCloseAroundATube) {
  const json scene = json::parse(R"({
    "materials": {"cotton": {}},
    "cloths": [
      {"name": "tube", "material": "cotton", "cylinder": {"radius": 0.2, "height": 0.3, "cells": [16, 4]}},
      {"name": "band", "material": "cotton", "grid": {"size": [1, 0.1], "cells": [12, 1]},
       "transform": {"translate": [0, -0.25, 0.2], "rotate": [90, 1, 0, 0]}}],
    "seams": [{"between": [{"cloth": "tube", "edge": "top"}, {"cloth": "band", "edge": "bottom"}]}]})");
  const Scene read = read_scene(put("tube.json", scene.dump()));
  const Seam& seam = read.seams.at(0);
  EXPECT_EQ(seam.vertices[0].front(), seam.vertices[0].back());
  EXPECT_NE(seam.vertices[1].front(), seam.vertices[1].back());
}

TEST_F(SceneSeams, TrianglesThatWouldLieOnEachOtherArePart) {
  json scene = garment(R"([
      {"between": [{"cloth": "front", "edge": "top"}, {"cloth": "back", "edge": "top"}]},
      {"between": [{"cloth": "front", "edge": "right"}, {"cloth": "back", "edge": "left"}]}])");
  // The diagonals of their common corner cut off the same triangle.
  for (json& cloth : scene["cloths"]) cloth["grid"]["cells"] = {2, 3};
  const Scene read = read_scene(put("garment.json", scene.dump()));
  EXPECT_EQ(read.cloths[0].mesh.positions.size() + read.cloths[1].mesh.positions.size(), 25u);
  EXPECT_EQ(read.warnings.size(), 1u);
}

TEST(NearestPairs, AreThoseOfAllPairsCompared) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto cloud = [&](std::size_t count) {
    std::vector<Vec3<double>> points;
    for (std::size_t k = 0; k < count; ++k) points.push_back({any(random), any(random), 0});
    return points;
  };
  const auto nearest = [](const Vec3<double>& x, const std::vector<Vec3<double>>& points) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < points.size(); ++k)
      if (length(points[k] - x) < length(points[best] - x)) best = k;
    return best;
  };
  for (const std::size_t count : {1u, 7u, 8u, 9u, 200u}) {
    const auto a = cloud(count);
    const auto b = cloud(2 * count);
    std::vector<std::pair<Index, Index>> expected;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const std::size_t j = nearest(a[i], b);
      if (nearest(b[j], a) == i)
        expected.emplace_back(static_cast<Index>(i), static_cast<Index>(j));
    }
    EXPECT_EQ(nearest_pairs(a, b), expected) << count;
  }
  EXPECT_TRUE(nearest_pairs({}, cloud(3)).empty());
}

TEST(NearestPairs, OfSeveralAtOneDistanceTakeTheFirst) {
  const std::vector<Vec3<double>> a{{0, 0, 0}};
  std::vector<Vec3<double>> b(20, Vec3<double>{1, 0, 0});
  EXPECT_EQ(nearest_pairs(a, b), (std::vector<std::pair<Index, Index>>{{0, 0}}));
  EXPECT_EQ(nearest_pairs(b, a), (std::vector<std::pair<Index, Index>>{{0, 0}}));
}

}  // namespace
}  // namespace weft::io
