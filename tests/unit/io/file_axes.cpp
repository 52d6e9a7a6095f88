#include "host/io/scene/file_axes.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

/// A cloth and a body, written as other programs do: in centimetres, with y up.
class FileAxesTest : public DirectoryTest {
 protected:
  FileAxesTest()
      : sheet_(make_grid({0.4, 0.3}, {4, 3}, Diagonals::same)),
        box_(make_box({0.2, 0.4, 0.6}, {1, 1, 1})) {
    for (Vec3<double>& x : sheet_.positions) x[2] = 0.7;
    write_obj(directory_ / "sheet.obj", {{"sheet", foreign(sheet_)}});
    write_obj(directory_ / "box.obj", {{"box", foreign(box_)}});
  }

  static Mesh foreign(Mesh mesh) {
    for (Vec3<double>& x : mesh.positions) x = {100 * x[0], 100 * x[2], -100 * x[1]};
    for (Vec2<double>& u : mesh.material) u *= 100;
    return mesh;
  }
  json scene() const {
    return {{"materials", {{"m", json::object()}}},
            {"cloths", {{{"mesh", "sheet.obj"}, {"material", "m"}}}},
            {"obstacles", {{{"mesh", "box.obj"}}}}};
  }
  Scene read(const json& scene) const { return read_scene(put("scene.json", scene.dump())); }
  void expect_native(const Scene& scene) const {
    const Mesh& cloth = scene.cloths[0].mesh;
    ASSERT_EQ(cloth.positions.size(), sheet_.positions.size());
    for (std::size_t v = 0; v < cloth.positions.size(); ++v) {
      EXPECT_LT(length(cloth.positions[v] - sheet_.positions[v]), 1e-9);
      EXPECT_LT(length(cloth.material[v] - sheet_.material[v]), 1e-9);
    }
    const Mesh& body = scene.obstacles[0].mesh;
    for (std::size_t v = 0; v < body.positions.size(); ++v)
      EXPECT_LT(length(body.positions[v] - box_.positions[v]), 1e-9);
    EXPECT_TRUE(scene.warnings.empty());
  }

  Mesh sheet_, box_;
};

TEST_F(FileAxesTest, OfTheSceneAreThoseOfAllMeshFiles) {
  json scene = this->scene();
  scene["units"] = "cm";
  scene["up"] = "y";
  expect_native(read(scene));
}

TEST_F(FileAxesTest, OfAMeshGoFirst) {
  json scene = this->scene();
  scene["units"] = "ft";
  for (json* mesh : {&scene["cloths"][0], &scene["obstacles"][0]}) {
    (*mesh)["units"] = "cm";
    (*mesh)["up"] = "y";
  }
  expect_native(read(scene));
}

TEST_F(FileAxesTest, AreThoseOfTheRestShapeToo) {
  json scene = this->scene();
  scene["units"] = "cm";
  scene["up"] = "y";
  scene["cloths"][0]["rest"] = "sheet.obj";
  const Cloth cloth = read(scene).cloths[0];
  ASSERT_EQ(cloth.rest_positions.size(), sheet_.positions.size());
  for (std::size_t v = 0; v < sheet_.positions.size(); ++v)
    EXPECT_LT(length(cloth.rest_positions[v] - sheet_.positions[v]), 1e-9);
}

TEST_F(FileAxesTest, AreMetresWithZUpByDefault) {
  const Scene scene = read(this->scene());
  const Mesh as_written = foreign(sheet_);
  EXPECT_LT(length(scene.cloths[0].mesh.positions[5] - as_written.positions[5]), 1e-9);
}

TEST_F(FileAxesTest, OfShapesAreRefused) {
  json scene = this->scene();
  scene["obstacles"][0] = {{"sphere", {{"radius", 1}}}, {"units", "cm"}};
  const auto refusal = [&] {
    try {
      read(scene);
    } catch (const SceneError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal().find("obstacles[0].units"), std::string::npos) << refusal();
  scene["obstacles"][0].erase("units");
  scene["cloths"][0]["units"] = "km";
  EXPECT_NE(refusal().find("cloths[0].units"), std::string::npos) << refusal();
  EXPECT_NE(refusal().find("cm"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace weft::io
