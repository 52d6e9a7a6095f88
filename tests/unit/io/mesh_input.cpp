// Cloths from mesh files: groups that pins name, shapes at rest without texture coordinates, USD.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/model/model.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/io.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

/// Two squares side by side. The second is of silk; `waist` is the left half of the first.
const std::string two_squares = R"(
o shirt
v 0 0 0
v 1 0 0
v 2 0 0
v 0 1 0
v 1 1 0
v 2 1 0
vw 1 2 3
usemtl denim
g waist
f 1 2 4
g body
f 2 5 4
usemtl silk
f 2 3 5
f 3 6 5
freeform x
)";

class MeshInput : public DirectoryTest {
 protected:
  json scene(const std::string& mesh) const {
    return {{"materials", {{"m", json::object()}, {"n", json::object()}}},
            {"cloths", {{{"name", "cloth"}, {"mesh", mesh}, {"material", "m"}}}}};
  }
  Scene read(const json& scene) const { return read_scene(put("scene.json", scene.dump())); }
  std::string refusal(const json& scene) const {
    try {
      read(scene);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(MeshInput, PinsNameGroupsThoughMaterialsNameFacesToo) {
  put("shirt.obj", two_squares);
  json scene = this->scene("shirt.obj");
  scene["cloths"][0]["material"] = {{"denim", "m"}, {"silk", "n"}};
  scene["pins"] = {{{"cloth", "cloth"}, {"group", "waist"}}};
  scene["handles"] = {{{"cloth", "cloth"}, {"group", "silk"}}};
  const Scene read = this->read(scene);
  EXPECT_EQ(read.pins.at(0).vertices, (std::vector<Index>{0, 1, 3}));
  EXPECT_EQ(read.handles.at(0).vertices, (std::vector<Index>{1, 2, 4, 5}));
  EXPECT_EQ(read.cloths[0].triangle_material, (std::vector<Index>{0, 0, 1, 1}));
  ASSERT_EQ(read.warnings.size(), 1u) << "one line for all keywords that are unknown";
  EXPECT_NE(read.warnings[0].find("keyword \"vw\" is unknown and passed over, the first of 2"),
            std::string::npos)
      << read.warnings[0];
  scene["pins"][0]["group"] = "wast";
  EXPECT_NE(refusal(scene).find("did you mean \"waist\"?"), std::string::npos) << refusal(scene);
  // The program's own way.
  Scene own;
  const ClothId cloth = own.add(Cloth{.mesh = load_mesh(directory_ / "shirt.obj")});
  const PinId pin = own.pin(cloth, group("waist"));
  EXPECT_EQ(own.pins[static_cast<std::size_t>(pin.index)].vertices, (std::vector<Index>{0, 1, 3}));
}

TEST_F(MeshInput, GroupsOutliveRepair) {
  // The first face again, so that there is something to drop.
  put("shirt.obj", two_squares + "g body\nf 1 2 4\n");
  json scene = this->scene("shirt.obj");
  scene["cloths"][0]["repair"] = true;
  scene["pins"] = {{{"cloth", "cloth"}, {"group", "waist"}}};
  const Scene read = this->read(scene);
  EXPECT_EQ(read.cloths[0].mesh.triangles.size(), 4u);
  EXPECT_EQ(read.pins.at(0).vertices, (std::vector<Index>{0, 1, 3}));
}

/// Edge lengths of triangles in material space over those in the world, at worst.
double worst_stretch(const Mesh& mesh) {
  double worst = 0;
  const auto& corners = mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto x = [&](int j) {
        return mesh.positions[static_cast<std::size_t>(mesh.triangles[t].v[j % 3])];
      };
      const auto u = [&](int j) {
        return mesh.material[static_cast<std::size_t>(corners[t].v[j % 3])];
      };
      worst = std::max(worst, std::abs(length(u(k + 1) - u(k)) / length(x(k + 1) - x(k)) - 1));
    }
  return worst;
}

TEST_F(MeshInput, CurvedMeshesWithoutCoordinatesRestAsTheyStart) {
  Mesh dome = make_icosphere(0.5, 2);
  Mesh sheet = make_grid({1, 1}, {8, 4}, Diagonals::alternating);
  for (auto& x : sheet.positions)
    x = {0.4 * std::sin(x[0] / 0.4), x[1], 0.4 * std::cos(x[0] / 0.4)};
  sheet.material.clear();
  write_obj(directory_ / "dome.obj", {{"", dome}});
  write_obj(directory_ / "sheet.obj", {{"", sheet}});
  for (const std::string name : {"dome.obj", "sheet.obj"}) {
    json scene = this->scene(name);
    EXPECT_NE(refusal(scene).find("\"rest\": \"initial\""), std::string::npos) << refusal(scene);
    scene["cloths"][0]["rest"] = "initial";
    const Cloth cloth = read(scene).cloths[0];
    EXPECT_LT(worst_stretch(cloth.mesh), 1e-9) << name;
    EXPECT_EQ(cloth.rest_positions.size(), cloth.mesh.positions.size()) << name;
    // A cylinder unrolls; a sphere does not.
    EXPECT_EQ(cloth.mesh.material_triangles.empty(), name == "sheet.obj") << name;
  }
}

TEST_F(MeshInput, ClothFromUsd) {
  put("shirt.usda", R"(#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Xform "root"
{
    def Mesh "shirt"
    {
        int[] faceVertexCounts = [4, 4]
        int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
        point3f[] points = [(0, 0, 0), (100, 0, 0), (200, 0, 0), (0, 100, 0), (100, 100, 0), (200, 100, 0)]
        texCoord2f[] primvars:st = [(0, 0), (0.5, 0), (1, 0), (0, 0.5), (0.5, 0.5), (1, 0.5)] (
            interpolation = "vertex"
        )
        def GeomSubset "waist"
        {
            uniform token elementType = "face"
            int[] indices = [1]
            rel material:binding = </mats/silk>
        }
    }
}
)");
  json scene = this->scene("shirt.usda");
  scene["cloths"][0]["uv"] = "fit";
  scene["cloths"][0]["material"] = {{"", "m"}, {"silk", "n"}};
  scene["pins"] = {{{"cloth", "cloth"}, {"group", "waist"}}};
  // Those of other mesh files.
  scene["units"] = "mm";
  const Scene read = this->read(scene);
  const Cloth& cloth = read.cloths.at(0);
  EXPECT_EQ(cloth.mesh.positions[5], (Vec3<double>{2, 0, 1}));
  EXPECT_LT(worst_stretch(cloth.mesh), 1e-6);
  EXPECT_EQ(cloth.triangle_material, (std::vector<Index>{0, 0, 1, 1}));
  EXPECT_EQ(read.pins.at(0).vertices, (std::vector<Index>{1, 2, 4, 5}));
  scene["cloths"][0]["up"] = "y";
  EXPECT_NE(refusal(scene).find("cloths[0].up: "), std::string::npos) << refusal(scene);
}

}  // namespace
}  // namespace weft::io
