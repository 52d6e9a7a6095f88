#include "host/io/animation/skinned_file.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

#include "host/geometry/mesh_check.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A glTF file and its buffer, filled piece by piece.
struct Gltf {
  json document = {{"asset", {{"version", "2.0"}}},
                   {"accessors", json::array()},
                   {"bufferViews", json::array()}};
  std::string bytes;

  /// @return number of the accessor
  template <class T>
  int add(const std::vector<T>& numbers, int component_type, const char* type, int width) {
    while (bytes.size() % 4 != 0) bytes += '\0';
    const std::size_t size = numbers.size() * sizeof(T);
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
    bytes.append(reinterpret_cast<const char*>(numbers.data()), size);
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", component_type},
                                     {"count", numbers.size() / static_cast<std::size_t>(width)},
                                     {"type", type}});
    return static_cast<int>(document["accessors"].size()) - 1;
  }
  int floats(const std::vector<float>& numbers, const char* type, int width) {
    return add(numbers, 5126, type, width);
  }
};

/// A strip of two quads along x, bound to two joints at x = 0 and 1. Vertices 6 and 7 are 2 and 3
/// again, as exporters write them at a seam. In two seconds the forearm turns by 90 degrees about
/// z and the upper arm moves by 1 along y.
Gltf arm() {
  const float s = std::sqrt(0.5f);
  Gltf g;
  const int positions = g.floats(
      {0, -.1f, 0, 0, .1f, 0, 1, -.1f, 0, 1, .1f, 0, 2, -.1f, 0, 2, .1f, 0, 1, -.1f, 0, 1, .1f, 0},
      "VEC3", 3);
  g.document["accessors"][0]["min"] = {0, -.1, 0};
  g.document["accessors"][0]["max"] = {2, .1, 0};
  std::vector<unsigned char> joints;
  std::vector<float> weights;
  for (const float fore : {0.0f, 0.0f, 0.5f, 0.5f, 1.0f, 1.0f, 0.5f, 0.5f}) {
    joints.insert(joints.end(), {0, 1, 0, 0});
    weights.insert(weights.end(), {1 - fore, fore, 0, 0});
  }
  const int joint_numbers = g.add(joints, 5121, "VEC4", 4);
  const int weight_numbers = g.floats(weights, "VEC4", 4);
  const int indices =
      g.add(std::vector<std::uint16_t>{0, 2, 1, 1, 2, 3, 6, 4, 7, 7, 4, 5}, 5123, "SCALAR", 1);
  const int binds = g.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,  //
                              1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1},
                             "MAT4", 16);
  const int times = g.floats({0, 2}, "SCALAR", 1);
  const int turns = g.floats({0, 0, 0, 1, 0, 0, s, s}, "VEC4", 4);
  const int shifts = g.floats({0, 0, 0, 0, 1, 0}, "VEC3", 3);
  g.document["meshes"] =
      json::array({{{"primitives", json::array({{{"attributes",
                                                  {{"POSITION", positions},
                                                   {"JOINTS_0", joint_numbers},
                                                   {"WEIGHTS_0", weight_numbers}}},
                                                 {"indices", indices}}})}}});
  g.document["nodes"] = json::array({{{"name", "body"}, {"mesh", 0}, {"skin", 0}},
                                     {{"name", "upper"}, {"children", {2}}},
                                     {{"name", "fore"}, {"translation", {1, 0, 0}}}});
  g.document["skins"] = json::array({{{"joints", {1, 2}}, {"inverseBindMatrices", binds}}});
  g.document["scenes"] = json::array({{{"nodes", {0, 1}}}});
  g.document["scene"] = 0;
  g.document["animations"] = json::array(
      {{{"name", "bend"},
        {"samplers", json::array({{{"input", times}, {"output", turns}},
                                  {{"input", times}, {"output", shifts}}})},
        {"channels",
         json::array({{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}},
                      {{"sampler", 1}, {"target", {{"node", 1}, {"path", "translation"}}}}})}}});
  return g;
}

class SkinnedFileTest : public DirectoryTest {
 protected:
  fs::path put_gltf(Gltf g) const {
    put("arm.bin", g.bytes);
    g.document["buffers"] = json::array({{{"uri", "arm.bin"}, {"byteLength", g.bytes.size()}}});
    return put("arm.gltf", g.document.dump());
  }
  std::string refusal(const fs::path& path, const SkinnedChoice& choice) {
    try {
      read_skinned(path, choice, warnings_);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }
  std::vector<std::string> warnings_;
};

std::vector<Vec3<double>> at(const SkinnedSurface& surface, double time) {
  std::vector<Vec3<double>> out(surface.skin.rest.size());
  SkinnedDeformation(surface.skin, {}).positions(time, out);
  return out;
}

void expect_point(const std::vector<Vec3<double>>& points, const Vec3<double>& x) {
  double nearest = 1e9;
  for (const auto& p : points) nearest = std::min(nearest, length(p - x));
  EXPECT_LT(nearest, 1e-6) << x[0] << " " << x[1] << " " << x[2];  // the file holds floats
}

TEST_F(SkinnedFileTest, ArmByHand) {
  SkinnedChoice choice;
  choice.y_up = false;
  const SkinnedSurface surface = read_skinned(put_gltf(arm()), choice, warnings_);
  EXPECT_TRUE(warnings_.empty());
  EXPECT_EQ(surface.skin.rest.size(), 6u) << "the seam is closed";
  EXPECT_EQ(surface.triangles.size(), 4u);
  EXPECT_NEAR(surface.skin.duration, 2, 1e-6);
  for (const double t : {0.0, 0.5, 1.0, 2.0}) {
    const auto points = at(surface, t);
    const double angle = t / 2 * std::numbers::pi / 2;
    const Vec3<double> u{std::cos(angle), std::sin(angle), 0};
    const Vec3<double> n{-std::sin(angle), std::cos(angle), 0};
    const Vec3<double> elbow{1, t / 2, 0};
    for (const double side : {-0.1, 0.1}) {
      expect_point(points, {0, t / 2 + side, 0});
      expect_point(points, elbow + u + n * side);
      expect_point(points, elbow + (n * side + Vec3<double>{0, side, 0}) * 0.5);
    }
  }
}

TEST_F(SkinnedFileTest, UnitsAxesAndNames) {
  SkinnedChoice choice;
  choice.scale = 0.5;
  choice.name = "bend";
  const SkinnedSurface surface = read_skinned(put_gltf(arm()), choice, warnings_);
  expect_point(at(surface, 0), {1, 0, 0.05});  // y is up: (2, 0.1, 0) of the file
  choice.name = "walk";
  EXPECT_NE(refusal(directory_ / "arm.gltf", choice).find("\"walk\"; allowed: "),
            std::string::npos);
  EXPECT_NE(refusal(directory_ / "arm.gltf", choice).find("\"bend\""), std::string::npos);
  choice.name.reset();
  choice.animation = 1;
  EXPECT_NE(refusal(directory_ / "arm.gltf", choice).find("0 to 0"), std::string::npos);
}

TEST_F(SkinnedFileTest, MeshesOfAllNodesStandWhereTheirNodesDo) {
  Gltf g = arm();
  g.document["nodes"].push_back(
      {{"name", "hat"}, {"mesh", 1}, {"translation", {0, 0, 5}}, {"scale", {2, 2, 2}}});
  g.document["nodes"][2]["children"] = {3};  // carried by the forearm
  json hat = g.document["meshes"][0];
  hat["primitives"][0]["attributes"].erase("JOINTS_0");
  hat["primitives"][0]["attributes"].erase("WEIGHTS_0");
  g.document["meshes"].push_back(hat);
  SkinnedChoice choice;
  choice.y_up = false;
  const SkinnedSurface surface = read_skinned(put_gltf(g), choice, warnings_);
  EXPECT_EQ(surface.skin.rest.size(), 12u);
  EXPECT_EQ(surface.triangles.size(), 8u);
  expect_point(at(surface, 0), {1 + 4, 0.2, 5});
  expect_point(at(surface, 2), {1 - 0.2, 1 + 4, 5});
}

TEST_F(SkinnedFileTest, WhatCannotBeTakenOverIsRefused) {
  Gltf still = arm();
  still.document.erase("animations");
  EXPECT_NE(refusal(put_gltf(still), {}).find("animation: none in the file"), std::string::npos);
  EXPECT_NE(refusal(put("text.gltf", "no glTF"), {}).find("text.gltf"), std::string::npos);
  EXPECT_NE(refusal(put("body.unknown", "x"), {}).find("format"), std::string::npos);
  EXPECT_NE(refusal(directory_ / "none.fbx", {}).find("No such file"), std::string::npos);
}

const fs::path models = "/usr/share/assimp/models";

/// Its reader would fill two gigabytes first.
TEST_F(SkinnedFileTest, ChunkBeyondTheEndOfTheFileIsRefused) {
  const std::string header("glTF\x02\0\0\0\x8c\x06\0\0\0\0\0\x80JSON{\"asset\": {", 31);
  const std::string message = refusal(put("cut.glb", header), {});
  EXPECT_NE(message.find("cut.glb: cannot read as an animated mesh: its first chunk has 2147483648 "
                         "bytes, of which the file has 11"),
            std::string::npos)
      << message;
}

TEST_F(SkinnedFileTest, MorphTargetsAreRefused) {
  const fs::path path =
      models / "glTF2" / "glTF-Sample-Models" / "AnimatedMorphCube-glTF" / "AnimatedMorphCube.gltf";
  if (!fs::exists(path))
    GTEST_SKIP() << "NOT TESTED: " << path << " is missing; install assimp-testmodels";
  EXPECT_NE(refusal(path, {}).find("morph targets"), std::string::npos) << refusal(path, {});
}

/// Real files, from Debian's assimp-testmodels.
class RealSkinned : public testing::TestWithParam<const char*> {};

TEST_P(RealSkinned, IsAManifoldSurfaceThatMoves) {
  const fs::path path = models / GetParam();
  if (!fs::exists(path))
    GTEST_SKIP() << "NOT TESTED: " << path << " is missing; install assimp-testmodels";
  std::vector<std::string> warnings;
  const SkinnedSurface surface = read_skinned(path, {}, warnings);
  ASSERT_GT(surface.skin.duration, 0);
  Mesh mesh{at(surface, 0), {}, surface.triangles, {}, {}, {}};
  check_mesh(mesh, {path.string(), "mesh", ""}, false);
  const std::vector<Vec3<double>> start = mesh.positions;
  double size = 0;
  for (const Vec3<double>& x : start) size = std::max(size, length(x - start.front()));
  double farthest = 0;
  for (int i = 1; i <= 20; ++i) {
    const auto now = at(surface, i / 20.0 * surface.skin.duration);
    for (std::size_t v = 0; v < start.size(); ++v) {
      ASSERT_TRUE(std::isfinite(length(now[v])));
      farthest = std::max(farthest, length(now[v] - start[v]));
    }
  }
  EXPECT_GT(farthest, 0.01 * size);
  EXPECT_LT(farthest, 20 * size);
  // Continuous: a thousandth of the clip later nothing is far away.
  const auto a = at(surface, 0.4 * surface.skin.duration);
  const auto b = at(surface, 0.4001 * surface.skin.duration);
  for (std::size_t v = 0; v < a.size(); ++v) ASSERT_LT(length(a[v] - b[v]), 0.1 * size);
}

INSTANTIATE_TEST_SUITE_P(Debian, RealSkinned,
                         testing::Values("FBX/animation_with_skeleton.fbx", "FBX/huesitos.fbx",
                                         "glTF2/simple_skin/simple_skin.gltf", "X/anim_test.x",
                                         "X/Testwuson.X", "X/BCN_Epileptic.X",
                                         "Collada/anims_with_full_rotations_between_keys.DAE",
                                         "Collada/box_nested_animation.dae"),
                         [](const auto& param) {
                           std::string name = fs::path(param.param).stem().string();
                           return name;
                         });

}  // namespace
}  // namespace weft::io
