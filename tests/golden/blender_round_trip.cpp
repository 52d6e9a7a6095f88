// Blender reads what `weft run` writes and finds the same vertices in the same places.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "host/io/mesh/split_objects.hpp"
#include "tests/golden/round_trip.hpp"

namespace weft::test {
namespace {

constexpr int cannot_read = 77;

class SlowBlender : public RoundTrip {
 protected:
  void SetUp() override {
    if (std::system("command -v blender >/dev/null 2>&1") != 0)
      GTEST_SKIP() << "NOT TESTED: there is no Blender (package blender)";
    Process::SetUp();
  }

  /// The objects that a file names, each as a mesh.
  static io::FrameMeshes parted_by_object(io::FrameMeshes meshes) {
    for (auto* list : {&meshes.cloths, &meshes.obstacles})
      *list = io::split_objects(std::move(list->front()));
    return meshes;
  }

  /// @param tolerance of the size of the mesh
  static void expect_near(const std::vector<Vec3<double>>& other,
                          const std::vector<Vec3<double>>& weft, double tolerance) {
    ASSERT_EQ(other.size(), weft.size());
    double size = 0;
    for (const Vec3<double>& x : weft) size = std::max(size, length(x - weft.front()));
    for (std::size_t v = 0; v < weft.size(); ++v)
      ASSERT_LT(length(other[v] - weft[v]), tolerance * size) << "vertex " << v;
  }

  /// @return the exit code of Blender
  int read_with_blender(const std::string& mode, const fs::path& file) {
    return call("blender -b --factory-startup --python-exit-code 1 --python '" +
                std::string(WEFT_SOURCE_DIR) + "/tests/support/blender_positions.py' -- " + mode +
                " '" + file.string() + "' '" + at("positions").string() + "'" + frame_arguments());
  }
};

TEST_F(SlowBlender, Obj) {
  ASSERT_EQ(run("a"), 0) << err_;
  const fs::path file = at("a/frames/cloth_00006.obj");
  ASSERT_EQ(read_with_blender("obj", file), 0) << text_of(at("log"));
  auto positions = found();
  // Joined by weft, two objects to Blender.
  std::vector<Vec3<double>> all = positions[{0, "lower"}];
  all.insert(all.end(), positions[{0, "upper"}].begin(), positions[{0, "upper"}].end());
  expect_same(all, io::read_mesh(file).positions);
}

TEST_F(SlowBlender, PointCache) {
  ASSERT_EQ(run("a", {"--set", "output.format=pc2"}), 0) << err_;
  for (std::size_t cloth = 0; cloth < 2; ++cloth) {
    const std::string name = cloth == 0 ? "cloth.lower.pc2" : "cloth.upper.pc2";
    ASSERT_EQ(read_with_blender("pc2", at("a/frames") / name), 0) << text_of(at("log"));
    auto positions = found();
    ASSERT_EQ(positions.size(), frames.size());
    for (const int frame : frames)
      expect_same(positions[{frame, cloth == 0 ? "lower" : "upper"}],
                  expected("a", frame).cloths[cloth].mesh.positions);
  }
}

TEST_F(SlowBlender, Usd) {
  ASSERT_EQ(run("a", {"--set", "output.format=usda"}), 0) << err_;
  const int code = read_with_blender("usd", at("a/frames/animation.usda"));
  if (code == cannot_read) GTEST_SKIP() << "NOT TESTED: this Blender was built without USD";
  ASSERT_EQ(code, 0) << text_of(at("log"));
  auto positions = found();
  for (const int frame : frames) {
    const io::FrameMeshes meshes = expected("a", frame);
    expect_same(positions[{frame, "lower"}], meshes.cloths[0].mesh.positions);
    expect_same(positions[{frame, "upper"}], meshes.cloths[1].mesh.positions);
    expect_same(positions[{frame, "ball"}], meshes.obstacles[0].mesh.positions);
  }
}

TEST_F(SlowBlender, Glb) {
  // A ball that turns and travels, so that it moves by its node.
  Json scene = Json::parse(small_scene);
  scene["obstacles"][0]["motion"] = {
      {{"time", 0}}, {{"time", 1}, {"translate", {0.1, 0.05, 0.02}}, {"rotate", {50, 1, 2, 3}}}};
  scene["obstacles"].push_back({{"name", "floor"},
                                {"box", {{"size", {1, 2, 0.1}}, {"cells", {1, 1, 1}}}},
                                {"transform", {{"translate", {0, 0, -0.3}}}}});
  write("small.json", scene.dump());
  ASSERT_EQ(run("obj"), 0) << err_;
  ASSERT_EQ(run("a", {"--set", "output.format=glb"}), 0) << err_;
  ASSERT_EQ(weft({"convert", "obj", "converted.glb"}), 0) << err_;
  for (const fs::path& file : {at("a/frames/animation.glb"), at("converted.glb")}) {
    const int code = read_with_blender("glb", file);
    if (code == cannot_read) GTEST_SKIP() << "NOT TESTED: this Blender cannot read glTF";
    ASSERT_EQ(code, 0) << text_of(at("log"));
    auto positions = found();
    ASSERT_EQ(positions.size(), 4 * frames.size());
    for (const int frame : frames) {
      const io::FrameMeshes meshes = parted_by_object(expected("obj", frame));
      ASSERT_EQ(meshes.cloths.size(), 2u);
      ASSERT_EQ(meshes.obstacles.size(), 2u);
      for (const auto* list : {&meshes.cloths, &meshes.obstacles})
        for (const io::NamedMesh& named : *list)
          expect_near(positions[{frame, named.name}], named.mesh.positions, 1e-5);
    }
  }
}

}  // namespace
}  // namespace weft::test
