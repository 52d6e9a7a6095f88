// A USD library that shares no code with weft reads what `weft run` writes.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "tests/golden/round_trip.hpp"

namespace weft::test {
namespace {

class SlowUsd : public RoundTrip {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("WEFT_TINYUSDZ");
    if (!folder || std::system("command -v node >/dev/null 2>&1") != 0)
      GTEST_SKIP() << "NOT TESTED: needs node, and WEFT_TINYUSDZ set to the folder of the npm "
                      "package tinyusdz (npm install tinyusdz: node_modules/tinyusdz)";
    package_ = folder;
    RoundTrip::SetUp();
  }

  void read_usd(const fs::path& file) {
    const int code = call("node '" + std::string(WEFT_SOURCE_DIR) +
                          "/tests/support/usd_positions.mjs' '" + package_ + "' '" + file.string() +
                          "' '" + at("positions").string() + "'" + frame_arguments());
    ASSERT_EQ(code, 0) << text_of(at("log"));
  }

  std::string package_;
};

TEST_F(SlowUsd, PositionsOfAllFrames) {
  ASSERT_EQ(run("a", {"--set", "output.format=usda"}), 0) << err_;
  read_usd(at("a/frames/animation.usda"));
  auto positions = found();
  ASSERT_EQ(positions.size(), 3 * frames.size());
  for (const int frame : frames) {
    const io::FrameMeshes meshes = expected("a", frame);
    expect_same(positions[{frame, "lower"}], meshes.cloths[0].mesh.positions);
    expect_same(positions[{frame, "upper"}], meshes.cloths[1].mesh.positions);
    expect_same(positions[{frame, "ball"}], meshes.obstacles[0].mesh.positions);
  }
}

TEST_F(SlowUsd, MeshesOfTheScene) {
  ASSERT_EQ(run("a", {"--set", "output.format=usda"}), 0) << err_;
  read_usd(at("a/frames/animation.usda"));
  std::map<std::string, std::vector<Vec3<double>>> points;
  std::map<std::string, std::vector<std::array<Index, 3>>> faces;
  std::ifstream stream(at("positions.stage"));
  std::string word;
  std::string name;
  Vec3<double> x{};
  while (stream >> word >> name >> x[0] >> x[1] >> x[2]) {
    if (word == "points")
      points[name].push_back(x);
    else
      faces[name].push_back(
          {static_cast<Index>(x[0]), static_cast<Index>(x[1]), static_cast<Index>(x[2])});
  }
  const io::FrameMeshes meshes = expected("a", 0);
  const std::map<std::string, const Mesh*> all{
      {"/World/cloths/lower", &meshes.cloths[0].mesh},
      {"/World/cloths/upper", &meshes.cloths[1].mesh},
      {"/World/obstacles/ball", &meshes.obstacles[0].mesh}};
  ASSERT_EQ(points.size(), all.size());
  for (const auto& [path, mesh] : all) {
    expect_same(points[path], mesh->positions);
    ASSERT_EQ(faces[path].size(), mesh->triangles.size()) << path;
    for (std::size_t t = 0; t < mesh->triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_EQ(faces[path][t][k], mesh->triangles[t].v[k]) << path << " triangle " << t;
  }
}

TEST_F(SlowUsd, TopologyThatChanges) {
  // Two panels that are sewn and then split, one triangle into four.
  write("panels.json", R"({
    "gravity": [0, 0, 0],
    "time": {"frames": 6},
    "materials": {"cotton": {}},
    "cloths": [
      {"name": "front", "material": "cotton", "grid": {"size": [0.3, 0.3], "cells": [4, 4]},
       "transform": {"translate": [0, 0, 0.01]}},
      {"name": "back", "material": "cotton", "grid": {"size": [0.3, 0.3], "cells": [4, 4]},
       "transform": {"translate": [0, 0, -0.01], "rotate": [180, 0, 1, 0]}}],
    "seams": [{"between": [{"cloth": "front", "edge": "left"}, {"cloth": "back", "edge": "right"}],
               "ramp_time": 0}],
    "refine": {"when": "sewn"},
    "output": {"format": "usda"}
  })");
  ASSERT_EQ(weft({"run", "panels.json", "-o", "a", "--no-preview"}), 0) << err_;
  read_usd(at("a/frames/animation.usda"));
  auto positions = found();
  ASSERT_EQ((positions[{0, "front"}].size()), 25u);
  ASSERT_EQ((positions[{6, "front"}].size()), 81u);
  for (const int frame : frames) {
    const io::FrameMeshes meshes = expected("a", frame);
    expect_same(positions[{frame, "front"}], meshes.cloths[0].mesh.positions);
    expect_same(positions[{frame, "back"}], meshes.cloths[1].mesh.positions);
  }
}

}  // namespace
}  // namespace weft::test
