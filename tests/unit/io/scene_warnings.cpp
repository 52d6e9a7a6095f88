#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

/// What a reader warns of, because it is a mistake more often than not.
namespace weft::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SceneWarningsTest : public DirectoryTest {
 protected:
  /// A scene with one cloth of a file.
  json with_mesh() const {
    return {{"materials", {{"m", json::object()}}},
            {"cloths", {{{"mesh", "cloth.obj"}, {"material", "m"}}}}};
  }
  void put_mesh(const Mesh& mesh, const std::string& name = "cloth.obj") const {
    write_obj(directory_ / name, {{"cloth", mesh}});
  }
  Scene read(const json& scene) const { return read_scene(put("scene.json", scene.dump())); }
  /// All warnings of a scene.
  std::string warnings(const json& scene) const {
    std::string all;
    for (const std::string& warning : read(scene).warnings) all += warning + "\n";
    return all;
  }
};

/// A tube of these measures about the z axis, stood up along y if wanted.
Mesh tube(double radius, double height, bool along_y) {
  Mesh mesh = make_tube(radius, height, {12, 6});
  if (along_y)
    for (Vec3<double>& x : mesh.positions) x = {x[0], x[2], -x[1]};
  return mesh;
}

TEST_F(SceneWarningsTest, TextureCoordinatesFromZeroToOneAreNoticedAndFit) {
  Mesh mesh = make_grid({3, 2}, {6, 4}, Diagonals::same);
  put_mesh(mesh);
  EXPECT_EQ(warnings(with_mesh()), "");
  for (Vec2<double>& u : mesh.material) u *= 0.25;
  put_mesh(mesh);
  EXPECT_EQ(warnings(with_mesh()),
            "cloths[0].mesh: half of its edges start stretched by a factor of 4 or more, as its "
            "texture coordinates are taken for metres; \"uv\": \"fit\" scales these to the mesh\n");
  json scene = with_mesh();
  scene["cloths"][0]["uv"] = "fit";
  EXPECT_EQ(warnings(scene), "");
  const Mesh fitted = read(scene).cloths[0].mesh;
  for (std::size_t v = 0; v < fitted.material.size(); ++v)
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(fitted.material[v][k], fitted.positions[v][k], 1e-12);
}

TEST_F(SceneWarningsTest, TextureCoordinatesMayBeTooLargeToo) {
  Mesh mesh = make_grid({1, 1}, {4, 4}, Diagonals::same);
  for (Vec2<double>& u : mesh.material) u *= 1.2;
  put_mesh(mesh);
  EXPECT_EQ(warnings(with_mesh()), "") << "a garment may start compressed by a fifth";
  for (Vec2<double>& u : mesh.material) u *= 2;
  put_mesh(mesh);
  EXPECT_NE(warnings(with_mesh()).find("a factor of 0.417 or less"), std::string::npos);
}

TEST_F(SceneWarningsTest, WindWithoutDensityDoesNotAct) {
  json scene = with_mesh();
  put_mesh(make_grid({1, 1}, {2, 2}, Diagonals::same));
  scene["wind"] = {{"velocity", {3, 0, 0}}};
  EXPECT_EQ(warnings(scene),
            "wind: velocity [3.0,0.0,0.0] m/s and drag 0.0 have no effect, as density is 0; that "
            "of air is 1.2 kg/m^3\n");
  scene["wind"]["density"] = 1.2;
  EXPECT_EQ(warnings(scene), "");
}

TEST_F(SceneWarningsTest, GarmentsInCentimetresAreNoticed) {
  put_mesh(tube(25, 120, false));
  EXPECT_NE(warnings(with_mesh()).find("it is 120 m large; if its file is in centimetres"),
            std::string::npos);
  put_mesh(tube(250, 1200, false));
  EXPECT_NE(warnings(with_mesh()).find("in millimetres, \"units\": \"mm\""), std::string::npos);
  json scene = with_mesh();
  scene["cloths"][0]["transform"] = {{"scale", 0.01}};
  EXPECT_EQ(warnings(scene), "") << "the scene has decided";
  put_mesh(tube(4, 20, false));
  EXPECT_EQ(warnings(with_mesh()), "") << "a tent";
}

TEST_F(SceneWarningsTest, BodiesThatLieAlongYAreNoticed) {
  put_mesh(make_grid({0.2, 0.2}, {2, 2}, Diagonals::same));
  json scene = with_mesh();
  scene["cloths"][0]["transform"] = {{"translate", {0, 0, 5}}};
  scene["obstacles"] = {{{"mesh", "body.obj"}}};
  put_mesh(tube(0.2, 1.7, true), "body.obj");
  EXPECT_EQ(warnings(scene),
            "obstacles[0].mesh: it is 1.7 m long along y and 0.4 m along z, while gravity acts "
            "along z; if y is up in its file, \"up\": \"y\" puts it "
            "upright\n");
  json turned = scene;
  turned["obstacles"][0]["transform"] = {{"rotate", {90, 1, 0, 0}}};
  EXPECT_EQ(warnings(turned), "");
  json falling = scene;
  falling["gravity"] = {0, -9.81, 0};
  EXPECT_EQ(warnings(falling), "");
  put_mesh(tube(0.2, 1.7, false), "body.obj");
  EXPECT_EQ(warnings(scene), "") << "it stands along z";
  EXPECT_EQ(warnings(falling),
            "obstacles[0].mesh: it is 1.7 m long along z and 0.4 m along y, while gravity acts "
            "along y; if z is up, leave gravity out\n");
}

TEST_F(SceneWarningsTest, ValuesInOtherUnitsAreNoticed) {
  json scene{{"materials", {{"m", {{"density", 150}}}}},
             {"time", {{"step", 5}}},
             {"cloths",
              {{{"name", "large"},
                {"material", "m"},
                {"grid", {{"size", {100, 50}}, {"cells", {4, 2}}}},
                {"transform", {{"rotate", {1.5708, 1, 0, 0}}}}}}},
             {"contact", {{"thickness", 30}}},
             {"obstacles",
              {{{"sphere", {{"radius", 0.1}}},
                {"motion",
                 {{{"time", 0}, {"translate", {0, 0, -90}}},
                  {{"time", 1}, {"rotate", {-3.14, 0, 0, 1}}, {"translate", {0, 0, -90}}}}}}}}};
  EXPECT_EQ(warnings(scene),
            "cloths[0]: it is 100 m large; lengths in a scene are in metres\n"
            "materials.m.density: 150 kg/m^2; if these are g/m^2, write 0.15\n"
            "time.step: 5 s is longer than a frame of 0.04 s, which is taken in one step\n"
            "contact.thickness: 30 m is more than the cells of the cloths, 25 m; it is where "
            "contact begins, some 0.001 m for a fabric\n"
            "cloths[0].transform.rotate: [1.5708,1.0,0.0,0.0] turns by 1.5708 degrees; if these "
            "are radians, write 90\n"
            "obstacles[0].motion[1].rotate: [-3.14,0.0,0.0,1.0] turns by -3.14 degrees; if these "
            "are radians, write -180\n");
  scene["materials"]["m"]["density"] = 0.15;
  scene["time"]["step"] = 0.04;
  scene["cloths"][0]["transform"] = {{"scale", 0.1}, {"rotate", {1.6, 1, 0, 0}}};
  scene["contact"]["thickness"] = 1;
  scene["obstacles"][0]["motion"][1]["rotate"] = {-180, 0, 0, 1};
  EXPECT_EQ(warnings(scene), "");
}

/// A sheet whose left and right edges are sewn together.
json sewn_to_itself(const json& cloth) {
  json scene{{"cloths", {cloth}}};
  scene["cloths"][0]["name"] = "sheet";
  scene["cloths"][0]["fabric"] = "jersey";
  scene["seams"] = {
      {{"between",
        {{{"cloth", "sheet"}, {"edge", "left"}}, {{"cloth", "sheet"}, {"edge", "right"}}}}}};
  return scene;
}

TEST_F(SceneWarningsTest, SeamsThatCrushFlatClothAreNoticed) {
  const json upright{{"rotate", {70, 1, 2, 0}}, {"translate", {0, 0, 1}}};
  const json flat{{"grid", {{"size", {0.6, 0.4}}, {"cells", {6, 4}}}}, {"transform", upright}};
  json scene = sewn_to_itself(flat);
  EXPECT_EQ(warnings(scene),
            "seams[0].between: it sews cloth \"sheet\", which starts flat, to itself across its "
            "own plane, and so crushes it; use a \"cylinder\", or a mesh that is rolled already\n");
  scene["seams"][0]["start_time"] = 0.5;
  EXPECT_EQ(warnings(scene), "") << "it may hang by then";

  // Half of a roll.
  Mesh rolled = make_grid({0.6, 0.4}, {6, 4});
  for (Vec3<double>& x : rolled.positions) {
    const double angle = x[0] / 0.2;
    x = {0.2 * std::sin(angle), x[1], 0.2 * std::cos(angle)};
  }
  put_mesh(rolled);
  const auto ends = [](Index i) { return json{i, 7 + i, 14 + i, 21 + i, 28 + i}; };
  scene = sewn_to_itself({{"mesh", "cloth.obj"}});
  scene["seams"] = {{{"cloths", {"sheet", "sheet"}}, {"chains", {ends(0), ends(6)}}}};
  EXPECT_EQ(warnings(scene), "");
}

/// A dart's sides have no cloth between them, and gathers are short.
TEST_F(SceneWarningsTest, SeamsThatDoNotCrushFlatClothAreNot) {
  json scene = sewn_to_itself({{"grid", {{"size", {0.6, 0.4}}, {"cells", {12, 4}}}}});
  const auto column = [](Index i) { return json{i, 13 + i, 26 + i, 39 + i, 52 + i}; };
  scene["seams"] = {{{"cloths", {"sheet", "sheet"}}, {"chains", {column(4), column(8)}}}};
  EXPECT_EQ(warnings(scene), "") << "gathered by a third";
  Mesh wedge = make_grid({0.6, 0.4}, {6, 4});
  std::erase_if(wedge.triangles, [&](const Tri& t) {
    Vec3<double> middle{0, 0, 0};
    for (const Index v : t.v)
      middle = middle + wedge.positions[static_cast<std::size_t>(v)] * (1.0 / 3);
    return std::abs(middle[0]) < 0.2 && middle[1] > -0.1;
  });
  // The vertices within the notch are gone: numbers of its corners at the bottom and the top.
  std::vector<Index> number(wedge.positions.size(), -1);
  Mesh notched;
  for (Tri t : wedge.triangles) {
    for (Index& v : t.v) {
      Index& now = number[static_cast<std::size_t>(v)];
      if (now < 0) {
        now = static_cast<Index>(notched.positions.size());
        notched.positions.push_back(wedge.positions[static_cast<std::size_t>(v)]);
      }
      v = now;
    }
    notched.triangles.push_back(t);
  }
  put_mesh(notched);
  const auto side = [&](Index i) {
    json chain = json::array();
    for (Index row = 2; row <= 4; ++row)
      chain.push_back(number[static_cast<std::size_t>(7 * row + i)]);
    return chain;
  };
  scene = sewn_to_itself({{"mesh", "cloth.obj"}});
  scene["seams"] = {{{"cloths", {"sheet", "sheet"}}, {"chains", {side(1), side(5)}}}};
  EXPECT_EQ(warnings(scene), "");
}

TEST_F(SceneWarningsTest, UnknownKeywordsOfObjAreCountedOnce) {
  put("cloth.obj",
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nsurf 1\ncustom 2\nsurf 3\nvt 0 0\nvt 1 0\nvt 0 1\n"
      "f 1/1 2/2 3/3\n");
  EXPECT_EQ(warnings(with_mesh()),
            (directory_ / "cloth.obj").string() +
                ": line 4: keyword \"surf\" is unknown and passed over, the first of 3 such "
                "lines\n");
}

/// None of the heuristics may cry wolf.
TEST(SceneWarnings, ShippedScenesHaveNone) {
  int read = 0;
  for (const auto& entry : fs::directory_iterator(repository_root() / "scenes")) {
    const fs::path& path = entry.path();
    if (path.extension() != ".json" || path.filename() == "scene.schema.json") continue;
    const Scene scene = read_scene(path, {});
    for (const std::string& warning : scene.warnings) ADD_FAILURE() << path << ": " << warning;
    ++read;
  }
  EXPECT_GE(read, 20);
}

TEST_F(SceneWarningsTest, MethodIsShortForItsType) {
  put_mesh(make_grid({1, 1}, {2, 2}, Diagonals::same));
  json scene = with_mesh();
  scene["method"] = {{"integrator", "bdf2"}};
  const Scene changed = read_scene(put("scene.json", scene.dump()), {"method=adaptive"});
  EXPECT_EQ(changed.method, "adaptive");
  EXPECT_EQ(changed.integrator, Integrator::bdf2);
  EXPECT_THROW(read_scene(put("scene.json", scene.dump()), {"method=adaptve"}), SceneError);
}

TEST_F(SceneWarningsTest, NullMayBeSetWhereASceneMaySayIt) {
  put_mesh(make_grid({1, 1}, {2, 2}, Diagonals::same));
  json scene = with_mesh();
  scene["cloths"][0]["name"] = "c";
  scene["remeshing"] = {{"size", {0.1, 0.2}}};
  scene["contact"] = {{"compliance_distance", 0.1}};
  scene["pins"] = {{{"cloth", "c"}, {"vertices", {0}}, {"release_time", 1}}};
  scene["handles"] = {{{"cloth", "c"}, {"vertices", {2}}, {"end_time", 1}}};
  std::vector<std::string> all;
  for (const char* path :
       {"contact.compliance_distance", "remeshing.size", "remeshing.refine_angle",
        "remeshing.refine_compression", "remeshing.refine_velocity", "pins.0.release_time",
        "handles.0.end_time"})
    all.push_back(path + std::string("=null"));
  const Scene read =
      read_scene(put("scene.json", scene.dump()), all, {}, {"remeshing.energy_share=null"});
  EXPECT_TRUE(std::isinf(read.contact.compliance_distance.value_or(0)));
  EXPECT_EQ(read.adaptive.remeshing.size_min, 0);
  EXPECT_TRUE(std::isinf(read.adaptive.energy_share));
  EXPECT_TRUE(std::isinf(read.adaptive.remeshing.refine_angle));
  EXPECT_TRUE(std::isinf(read.pins[0].release_time));
  EXPECT_TRUE(std::isinf(read.handles[0].end_time));
}

}  // namespace
}  // namespace weft::io
