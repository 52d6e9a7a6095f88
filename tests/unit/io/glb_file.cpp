// Files of glTF, byte by byte and as assimp reads them.
#include "host/io/gltf/glb_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/file_bytes.hpp"
#include "host/io/animation/skinned_file.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/model/skinning.hpp"
#include "host/scene/frame_limits.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

using Json = nlohmann::json;

Mesh sheet(int frame) {
  Mesh mesh = make_grid({1, 1}, {3, 2}, Diagonals::alternating);
  for (auto& x : mesh.positions) x[2] = 0.1 * frame * x[0] * x[0];
  return mesh;
}

Mesh ball(int frame) {
  Mesh mesh = make_icosphere(0.25, 1);
  Transform turn;
  turn.rotation_axis = {0, 0.6, 0.8};
  turn.rotation_angle = 0.7 * frame;
  turn.scale = 1 + 0.1 * frame;
  turn.translate = {0.2 * frame, 1, -0.3 * frame};
  for (auto& x : mesh.positions) x = apply(turn, x);
  return mesh;
}

/// The text and the binary part of a file, whose heads are checked.
struct Glb {
  Json text;
  std::string binary;

  explicit Glb(const std::filesystem::path& path) {
    const std::string bytes = read_file_bytes(path);
    const auto number = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, sizeof value);
      return value;
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(number(4), 2u);
    EXPECT_EQ(number(8), bytes.size());
    const std::uint32_t text_size = number(12);
    EXPECT_EQ(text_size % 4, 0u);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    text = Json::parse(bytes.substr(20, text_size));
    EXPECT_EQ(bytes.substr(24 + text_size, 4), std::string("BIN\0", 4));
    binary = bytes.substr(28 + text_size);
    EXPECT_EQ(number(20 + text_size), binary.size());
    EXPECT_EQ(text.at("buffers")[0].at("byteLength"), binary.size());
  }

  template <class T>
  std::vector<T> values(const Json& accessor_number) const {
    const Json& accessor = text.at("accessors").at(accessor_number.get<std::size_t>());
    const Json& view = text.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    std::vector<T> result(accessor.at("count").get<std::size_t>());
    EXPECT_EQ(view.at("byteLength"), result.size() * sizeof(T));
    std::memcpy(result.data(), binary.data() + view.at("byteOffset").get<std::size_t>(),
                result.size() * sizeof(T));
    return result;
  }
  const Json& node(const std::string& name) const {
    const Json& nodes = text.at("nodes");
    const auto found = std::find_if(nodes.begin(), nodes.end(),
                                    [&](const Json& n) { return n.at("name") == name; });
    EXPECT_NE(found, nodes.end()) << name;
    return *found;
  }
};

class GlbFile : public DirectoryTest {
 protected:
  /// Frames 2 to 5 of a sheet, a ball that turns, grows and travels, and a floor.
  std::filesystem::path three(const Vec3<double>& origin = {0, 0, 0}) {
    const auto spool = directory_ / "a.spool";
    SpoolWriter writer(
        spool, 20, {{"shirt", false, {"denim", "silk"}}, {"ball", true}, {"floor", true}}, origin);
    for (int f = 2; f <= 5; ++f) {
      Mesh shirt = sheet(std::min(f, 4));  // at rest in the end
      shirt.group.assign(shirt.triangles.size(), 0);
      shirt.group[1] = 1;
      const Mesh turning = ball(f), floor = sheet(0);
      writer.append(f, {&shirt, &turning, &floor});
    }
    const auto path = directory_ / "a.glb";
    write_glb(path, SpoolReader(spool));
    return path;
  }
};

TEST_F(GlbFile, ClothHasATargetPerFrame) {
  const Glb file(three());
  const Json& mesh = file.text.at("meshes").at(file.node("shirt").at("mesh").get<std::size_t>());
  ASSERT_EQ(mesh.at("primitives").size(), 2u) << "one for each material";
  const Json& primitive = mesh.at("primitives")[0];
  ASSERT_EQ(primitive.at("targets").size(), 2u) << "frames 3 and 4; 2 is the mesh, 5 is 4";
  EXPECT_EQ(mesh.at("extras").at("targetNames"), (Json{"frame 3", "frame 4"}));
  const auto base = file.values<Vec3<float>>(primitive.at("attributes").at("POSITION"));
  for (std::size_t t = 0; t < 2; ++t) {
    const auto delta = file.values<Vec3<float>>(primitive.at("targets")[t].at("POSITION"));
    const Mesh now = sheet(3 + static_cast<int>(t));
    ASSERT_EQ(delta.size(), now.positions.size());
    for (std::size_t v = 0; v < delta.size(); ++v)
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(base[v][k] + delta[v][k], now.positions[v][k], 1e-7);
  }
  const Json& animation = file.text.at("animations")[0];
  const Json& channel = animation.at("channels")[0];
  EXPECT_EQ(channel.at("target").at("path"), "weights");
  const Json& sampler = animation.at("samplers")[channel.at("sampler").get<std::size_t>()];
  EXPECT_EQ(file.values<float>(sampler.at("input")),
            (std::vector<float>{0.1f, 0.15f, 0.2f, 0.25f}));
  EXPECT_EQ(file.values<float>(sampler.at("output")), (std::vector<float>{0, 0, 1, 0, 0, 1, 0, 1}));
  EXPECT_EQ(file.text.at("materials")[1].at("name"), "silk");
  EXPECT_EQ(file.values<std::uint32_t>(mesh.at("primitives")[1].at("indices")).size(), 3u);
}

TEST_F(GlbFile, BodiesMoveByTheirNodesAndFloorsStand) {
  const Glb file(three());
  for (const char* name : {"ball", "floor"}) {
    const Json& mesh = file.text.at("meshes").at(file.node(name).at("mesh").get<std::size_t>());
    EXPECT_FALSE(mesh.at("primitives")[0].contains("targets")) << name;
  }
  std::vector<std::string> paths;
  for (const Json& channel : file.text.at("animations")[0].at("channels"))
    if (channel.at("target").at("node") == &file.node("ball") - &file.text.at("nodes")[0])
      paths.push_back(channel.at("target").at("path"));
  EXPECT_EQ(paths, (std::vector<std::string>{"translation", "rotation", "scale"}));
}

double distance_to(const std::vector<Vec3<double>>& points, const Vec3<double>& x) {
  double nearest = 1e9;
  for (const Vec3<double>& p : points) nearest = std::min(nearest, length(p - x));
  return nearest;
}

/// assimp, which shares no code with the writer.
TEST_F(GlbFile, AnotherReaderFindsPositionsAxesAndMaterials) {
  const Vec3<double> origin{10, 20, 30};
  const Mesh read = read_mesh(three(origin), Uv::ignore);
  std::vector<std::string> groups = read.group_names;
  std::sort(groups.begin(), groups.end());
  EXPECT_EQ(groups, (std::vector<std::string>{"denim", "obstacle", "silk"}));
  EXPECT_EQ(read.triangles.size(), 2 * sheet(0).triangles.size() + ball(0).triangles.size());
  for (const Mesh& mesh : {sheet(2), ball(2), sheet(0)})
    for (const Vec3<double>& local : mesh.positions) {
      const Vec3<double> x = local + origin;
      // y up there.
      EXPECT_LT(distance_to(read.positions, {x[0], x[2], -x[1]}), 1e-5);
    }
}

TEST_F(GlbFile, AnotherReaderFindsTheMotionOfABody) {
  {
    SpoolWriter writer(directory_ / "a.spool", 20, {{"ball", true}});
    for (int f = 0; f < 4; ++f) {
      const Mesh turning = ball(f);
      writer.append(f, {&turning});
    }
  }
  write_glb(directory_ / "a.glb", SpoolReader(directory_ / "a.spool"));
  std::vector<std::string> warnings;
  const SkinnedSurface surface = read_skinned(directory_ / "a.glb", {}, warnings);
  std::vector<Vec3<double>> points(surface.skin.rest.size());
  for (int f = 0; f < 4; ++f) {
    SkinnedDeformation(surface.skin, {}).positions(f / 20.0, points);
    for (const Vec3<double>& x : ball(f).positions) EXPECT_LT(distance_to(points, x), 2e-6) << f;
  }
}

TEST_F(GlbFile, SeamsRepeatVertices) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.material = {{0, 0}, {1, 0}, {1, 1}, {5, 0}, {6, 1}, {5, 1}};
  mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
  mesh.material_triangles = {{{0, 1, 2}}, {{3, 4, 5}}};
  SpoolWriter(directory_ / "a.spool", 25, {{"cloth", false}}).append(0, {&mesh});
  write_glb(directory_ / "a.glb", SpoolReader(directory_ / "a.spool"));
  const Glb file(directory_ / "a.glb");
  const Json& primitive = file.text.at("meshes")[0].at("primitives")[0];
  EXPECT_EQ(file.values<Vec3<float>>(primitive.at("attributes").at("POSITION")).size(), 6u);
  EXPECT_EQ(file.values<std::uint32_t>(primitive.at("indices")),
            (std::vector<std::uint32_t>{0, 1, 2, 4, 5, 3}));
  const auto uv = file.values<Vec2<float>>(primitive.at("attributes").at("TEXCOORD_0"));
  EXPECT_EQ(uv[4], (Vec2<float>{5, 1})) << "downwards";
  EXPECT_FALSE(file.text.contains("animations"));
}

TEST_F(GlbFile, RefusesWhatItCannotHold) {
  const auto refusal = [&](const std::filesystem::path& spool) -> std::string {
    try {
      write_glb(directory_ / "a.glb", SpoolReader(spool));
      return "written";
    } catch (const SceneError& e) {
      return e.what();
    }
  };
  {
    SpoolWriter writer(directory_ / "a.spool", 25, {{"cloth", false}});
    const Mesh one = sheet(0), other = make_grid({1, 1}, {1, 1}, Diagonals::alternating);
    writer.append(0, {&one});
    writer.append(1, {&other});
  }
  EXPECT_NE(refusal(directory_ / "a.spool").find("triangles of cloth"), std::string::npos);
  {
    SpoolWriter writer(directory_ / "b.spool", 25, {{"cloth", false}});
    const Mesh still = make_grid({1, 1}, {1, 1}, Diagonals::alternating);
    for (int f = 0; f <= max_glb_frames; ++f) writer.append(f, {&still});
  }
  EXPECT_NE(refusal(directory_ / "b.spool").find("2001; allowed: up to 2000"), std::string::npos)
      << refusal(directory_ / "b.spool");
  EXPECT_FALSE(std::filesystem::exists(directory_ / "a.glb"));
}

}  // namespace
}  // namespace weft::io
