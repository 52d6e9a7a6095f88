#include "host/io/scene/scene_file.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <set>

#include "host/base/file_bytes.hpp"
#include "host/input/nearest_word.hpp"
#include "host/io/json/json_fields.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using SceneFileTest = DirectoryTest;
using nlohmann::json;
constexpr double pi = std::numbers::pi;

json minimal() {
  return json::parse(R"({
    "materials": {"cotton": {}},
    "cloths": [{"grid": {"size": [1, 1], "cells": [4, 4]}, "material": "cotton"}]
  })");
}

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double tolerance = 1e-14) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "component " << k;
}

void expect_same(const Mesh& a, const Mesh& b) {
  ASSERT_EQ(a.positions.size(), b.positions.size());
  ASSERT_EQ(a.material.size(), b.material.size());
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  for (std::size_t v = 0; v < a.positions.size(); ++v)
    EXPECT_TRUE(a.positions[v] == b.positions[v]) << v;
  for (std::size_t v = 0; v < a.material.size(); ++v)
    EXPECT_TRUE(a.material[v] == b.material[v]) << v;
  for (std::size_t t = 0; t < a.triangles.size(); ++t)
    EXPECT_EQ(std::memcmp(&a.triangles[t], &b.triangles[t], sizeof(Tri)), 0) << t;
}

TEST_F(SceneFileTest, AMeshIsNoScene) {
  try {
    read_scene(put("shirt.obj", "v 0 0 0"));
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("shirt.obj: scene: a mesh file; allowed: a "
                        "scene file, such as \"weft new\" writes"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(SceneFileTest, DefaultsAreThoseOfTheStructs) {
  const Scene scene = read_scene(put("minimal.json", minimal().dump()));
  const Scene bare;
  EXPECT_EQ(scene.name, "minimal");
  EXPECT_EQ(scene.file, (directory_ / "minimal.json").string());
  EXPECT_TRUE(scene.gravity == bare.gravity);
  EXPECT_EQ(scene.time.step, bare.time.step);
  EXPECT_EQ(scene.time.frames, bare.time.frames);
  EXPECT_EQ(contact_thickness(scene.contact), contact_thickness(bare.contact));
  EXPECT_EQ(scene.contact.self, bare.contact.self);
  EXPECT_EQ(scene.contact.zone_rounds, bare.contact.zone_rounds);
  EXPECT_EQ(scene.solver.partial_rows, bare.solver.partial_rows);
  EXPECT_EQ(scene.solver.tolerance, bare.solver.tolerance);
  EXPECT_EQ(scene.materials.at(0).name, "cotton");
  EXPECT_EQ(scene.materials.at(0).density, Material{}.density);
  EXPECT_EQ(scene.cloths.at(0).name, "cloth_0");
  EXPECT_EQ(scene.method, "implicit");
  EXPECT_EQ(scene.integrator, Integrator::implicit_euler);
  EXPECT_EQ(scene.precision, Precision::single_precision);
  EXPECT_TRUE(scene.obstacles.empty());
}

/// The schema, the structs and the reader name the same settings with the same defaults.
TEST_F(SceneFileTest, SchemaHasTheSameKeysAndDefaults) {
  const json resolved = resolved_scene_json(put("a.json", minimal().dump()));
  const std::filesystem::path schema_path = repository_root() / "scenes" / "scene.schema.json";
  const json schema = parse_json(read_file_bytes(schema_path), schema_path.string());
  const auto compare = [](const json& object, const json& described, const std::string& where) {
    for (const auto& [key, value] : object.items()) {
      ASSERT_TRUE(described.at("properties").contains(key)) << where << key;
      const json& property = described.at("properties").at(key);
      // what the small scene sets is not the default
      if (key == "materials" || !property.contains("default")) continue;
      EXPECT_EQ(property.at("default"), value) << where << key;
    }
    // stand instead of others, or say that something is declared, so they have no default
    const std::set<std::string> alternatives{"orthotropic", "orthotropic_bending",
                                             "measured",    "strain_limits",
                                             "fabric",      "compliance_distance"};
    for (const auto& [key, value] : described.at("properties").items())
      EXPECT_TRUE(object.contains(key) || alternatives.contains(key)) << where << key;
  };
  compare(resolved, schema, "");
  for (const char* section : {"time", "contact", "solver", "method", "output"})
    compare(resolved.at(section), schema.at("properties").at(section), section);
  const json& parts = schema.at("$defs");
  compare(resolved.at("materials").at("cotton"), parts.at("material"), "material");
  compare(resolved.at("cloths")[0].at("transform"), parts.at("placement"), "transform");
  compare(resolved.at("cloths")[0].at("copies"), parts.at("cloth").at("properties").at("copies"),
          "copies");
}

TEST_F(SceneFileTest, ShippedScenesResolveToThemselves) {
  for (const char* name : {"drape", "curtain", "stack"}) {
    const SceneFile first =
        read_scene_file(repository_root() / "scenes" / (std::string(name) + ".json"));
    EXPECT_EQ(first.scene.name, name);
    const SceneFile again = read_scene_file(put("scene.json", first.resolved.dump(2)));
    EXPECT_EQ(again.resolved, first.resolved) << name;
    ASSERT_EQ(again.scene.cloths.size(), first.scene.cloths.size());
    for (std::size_t i = 0; i < first.scene.cloths.size(); ++i)
      expect_same(again.scene.cloths[i].mesh, first.scene.cloths[i].mesh);
    for (std::size_t i = 0; i < first.scene.obstacles.size(); ++i)
      expect_same(again.scene.obstacles[i].mesh, first.scene.obstacles[i].mesh);
    ASSERT_EQ(again.scene.pins.size(), first.scene.pins.size());
    for (std::size_t i = 0; i < first.scene.pins.size(); ++i)
      EXPECT_EQ(again.scene.pins[i].vertices, first.scene.pins[i].vertices);
    EXPECT_EQ(contact_thickness(again.scene.contact), contact_thickness(first.scene.contact));
  }
}

TEST_F(SceneFileTest, ShippedScenesFollowTheTriangleKnob) {
  for (const char* name : {"drape", "curtain", "stack"})
    for (const double wanted : {1000.0, 20000.0, 300000.0}) {
      const Scene scene = read_scene(repository_root() / "scenes" / (std::string(name) + ".json"),
                                     {"triangles=" + std::to_string(static_cast<int>(wanted))});
      double count = 0;
      double area = 0;
      for (const Cloth& cloth : scene.cloths) {
        count += static_cast<double>(cloth.mesh.triangles.size());
        for (const Tri& t : cloth.mesh.triangles) {
          const auto& u = cloth.mesh.material;
          const auto e1 = u[static_cast<std::size_t>(t.v[1])] - u[static_cast<std::size_t>(t.v[0])];
          const auto e2 = u[static_cast<std::size_t>(t.v[2])] - u[static_cast<std::size_t>(t.v[0])];
          area += (e1[0] * e2[1] - e1[1] * e2[0]) / 2;
        }
      }
      EXPECT_NEAR(count / wanted, 1, 0.05) << name;
      const double edge = std::sqrt(2 * area / count);
      EXPECT_NEAR(contact_thickness(scene.contact), std::min(1e-3, edge / 4), 1e-9) << name;
      for (const Obstacle& o : scene.obstacles) EXPECT_LE(o.mesh.triangles.size(), 40000u) << name;
    }
}

TEST_F(SceneFileTest, CommentsAreAccepted) {
  EXPECT_NO_THROW(read_scene(put("a.json", "// first\n" + minimal().dump() + "// last")));
}

TEST_F(SceneFileTest, GridsShareTheTriangles) {
  json scene = minimal();
  scene["triangles"] = 3000;
  scene["cloths"] = json::parse(R"([
    {"name": "wide", "grid": {"size": [2, 0.5]}, "material": "cotton"},
    {"name": "large", "grid": {"size": [0.5, 0.5]}, "transform": {"scale": 2},
     "material": "cotton"},
    {"name": "own", "grid": {"size": [1, 1], "cells": [3, 5]}, "material": "cotton"},
    {"name": "many", "grid": {"size": [0.5, 0.5]}, "copies": {"count": 4, "translate": [0, 0, 1]},
     "material": "cotton"}
  ])");
  const Scene read = read_scene(put("a.json", scene.dump()));
  ASSERT_EQ(read.cloths.size(), 7u);
  // Each m^2 has 1000 triangles, cells of sqrt(2 / 1000) = 0.0447 m.
  EXPECT_EQ(read.cloths[0].mesh.triangles.size(), 2u * 45u * 11u);
  EXPECT_EQ(read.cloths[1].mesh.triangles.size(), 2u * 22u * 22u);
  EXPECT_EQ(read.cloths[2].mesh.triangles.size(), 2u * 3u * 5u);
  EXPECT_EQ(read.cloths[3].mesh.triangles.size(), 2u * 11u * 11u);
  // material coordinates scale with the cloth
  EXPECT_EQ(read.cloths[1].mesh.material.back()[0], 0.5);
  EXPECT_EQ(read.cloths[3].name, "many_0");
  EXPECT_EQ(read.cloths[6].name, "many_3");
}

TEST_F(SceneFileTest, TransformsAndCopies) {
  json scene = minimal();
  scene["cloths"][0]["transform"] = {{"translate", {1, 2, 3}}, {"rotate", {90, 2, 0, 0}}};
  scene["cloths"][0]["copies"] = {
      {"count", 3}, {"translate", {0, 0, 0.5}}, {"rotate", {90, 0, 0, 1}}};
  scene["cloths"][0]["pressure"] = -12;
  const Scene read = read_scene(put("a.json", scene.dump()));
  // first vertex: (-0.5, -0.5, 0), about x by 90 degrees
  expect_near(read.cloths.at(0).mesh.positions[0], {0.5, 2, 2.5});
  // turned about its own centre (1, 2, 3), then lifted
  expect_near(read.cloths.at(1).mesh.positions[0], {1, 1.5, 3});
  expect_near(read.cloths.at(2).mesh.positions[0], {1.5, 2, 3.5});
  EXPECT_EQ(read.cloths.at(2).mesh.material[0][0], -0.5);
  for (const Cloth& cloth : read.cloths) EXPECT_EQ(cloth.pressure, -12);
}

TEST_F(SceneFileTest, Obstacles) {
  json scene = minimal();
  scene["obstacles"] = json::parse(R"([
    {"sphere": {"radius": 0.5}},
    {"name": "floor", "plane": {"size": [2, 1], "cells": [4, 2]}, "friction": 0.7,
     "transform": {"translate": [0, 0, -1]}},
    {"box": {"size": [1, 1, 0.25]}, "motion": [
      {"time": 0}, {"time": 2, "translate": [1, 0, 0], "rotate": [180, 0, 1, 0], "scale": 2}]}
  ])");
  const Scene read = read_scene(put("a.json", scene.dump()));
  ASSERT_EQ(read.obstacles.size(), 3u);
  EXPECT_EQ(read.obstacles[0].name, "obstacle_0");
  // cells of 0.25 m: the icosahedron split once has edges of 0.29 m
  EXPECT_EQ(read.obstacles[0].mesh.triangles.size(), 80u);
  EXPECT_EQ(read.obstacles[1].mesh.triangles.size(), 16u);
  EXPECT_TRUE(read.obstacles[1].mesh.material.empty());
  EXPECT_EQ(read.obstacles[1].friction, 0.7);
  EXPECT_EQ(read.obstacles[1].transform.translate[2], -1);
  EXPECT_EQ(read.obstacles[2].mesh.triangles.size(), 4u * (16 + 4 + 4));
  EXPECT_EQ(read.obstacles[2].motion.at(1).time, 2);
  EXPECT_NEAR(read.obstacles[2].motion.at(1).transform.rotation_angle, pi, 1e-15);
  EXPECT_EQ(read.obstacles[2].motion.at(1).transform.scale, 2);
}

TEST_F(SceneFileTest, Pins) {
  json scene = minimal();
  scene["cloths"][0]["name"] = "a";
  scene["cloths"].push_back(json::parse(R"({"name": "b", "grid": {"size": [1, 1], "cells": [2, 3]},
    "transform": {"translate": [0, 0, 1]}, "material": "cotton",
    "copies": {"count": 2, "translate": [0, 0, 1]}})"));
  scene["pins"] = json::parse(R"([
    {"cloth": "a", "edge": "top"},
    {"cloth": "a", "corners": ["max_min", "min_min"], "release_time": 1.5},
    {"cloth": "b", "edge": "left"},
    {"cloth": "b_1", "corners": ["max_max"]},
    {"cloth": "b", "box": {"min": [0.4, -1, 1.5], "max": [0.6, 0, 9]},
     "motion": [{"time": 0}, {"time": 1, "translate": [0, 0, 1]}]},
    {"cloth": "a", "vertices": [6, 12]}
  ])");
  const Scene read = read_scene(put("a.json", scene.dump()));
  ASSERT_EQ(read.pins.size(), 7u);
  EXPECT_EQ(read.pins[0].vertices, (std::vector<Index>{20, 21, 22, 23, 24}));
  EXPECT_EQ(read.pins[0].release_time, std::numeric_limits<double>::infinity());
  EXPECT_EQ(read.pins[1].vertices, (std::vector<Index>{4, 0}));
  EXPECT_EQ(read.pins[1].release_time, 1.5);
  EXPECT_EQ(read.pins[2].cloth, 1);
  EXPECT_EQ(read.pins[3].cloth, 2);
  EXPECT_EQ(read.pins[3].vertices, (std::vector<Index>{0, 3, 6, 9}));
  EXPECT_EQ(read.pins[4].cloth, 2);
  EXPECT_EQ(read.pins[4].vertices, (std::vector<Index>{11}));
  // only the upper copy is in the box; the lower half of its right edge
  EXPECT_EQ(read.pins[5].cloth, 2);
  EXPECT_EQ(read.pins[5].vertices, (std::vector<Index>{2, 5}));
  EXPECT_EQ(read.pins[5].motion.size(), 2u);
  EXPECT_EQ(read.pins[6].vertices, (std::vector<Index>{6, 12}));
}

TEST_F(SceneFileTest, MeshCloths) {
  put("uv.obj", "v 0 0 0\nv 0 0 2\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  put("flat.obj", "v 5 0 0\nv 5 2 0\nv 5 0 2\nv 5 2 2\nf 1 2 4 3\n");
  put("seam.obj",
      "v 0 0 -3\nv 1 0 -3\nv 1 1 -3\nv 0 1 -3\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 3 3\n"
      "f 1/1 2/2 3/3\nf 1/5 3/3 4/4\n");
  json scene = minimal();
  scene["cloths"] = json::parse(R"([
    {"name": "uv", "mesh": "uv.obj", "material": "cotton", "transform": {"scale": 0.5}},
    {"name": "flat", "mesh": "flat.obj", "material": "cotton", "transform": {"scale": 2}}
  ])");
  scene["obstacles"] = json::parse(R"([{"mesh": "seam.obj"}])");
  const SceneFile file = read_scene_file(put("a.json", scene.dump()));
  const Mesh& uv = file.scene.cloths[0].mesh;
  expect_near(uv.positions[1], {0, 0, 1});
  EXPECT_EQ(uv.material[1][0], 0.5);
  const Mesh& flat = file.scene.cloths[1].mesh;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b)
      EXPECT_NEAR(length(flat.material[a] - flat.material[b]),
                  length(flat.positions[a] - flat.positions[b]), 1e-14);
  EXPECT_EQ(file.scene.obstacles[0].mesh.positions.size(), 4u);
  // The resolved scene stands elsewhere and still finds its meshes, if it may read them there.
  std::filesystem::create_directories(directory_ / "run");
  const auto elsewhere = put("run/scene.json", file.resolved.dump());
  EXPECT_THROW(read_scene(elsewhere), SceneError);
  const Scene again = read_scene(elsewhere, {}, file.folders);
  expect_same(again.cloths[1].mesh, flat);
}

TEST_F(SceneFileTest, Overrides) {
  json scene = minimal();
  scene["materials"]["denim"] = {{"density", 0.4}};
  const auto path = put("a.json", scene.dump());
  const SceneFile file = read_scene_file(
      path, {"time.step=0.002", "cloths.0.material=denim", "contact.thickness=0.0005",
             "precision=\"double\"", "gravity=[0, 0, -1]", "materials.cotton.damping.mass=3",
             "name=a=b", "cloths.0.grid.cells.1=2", "solver.newton_iterations=2e3"});
  EXPECT_EQ(file.scene.time.step, 0.002);
  EXPECT_EQ(file.scene.materials[static_cast<std::size_t>(file.scene.cloths[0].material)].name,
            "denim");
  EXPECT_EQ(contact_thickness(file.scene.contact), 0.0005);
  EXPECT_EQ(file.scene.precision, Precision::double_precision);
  EXPECT_EQ(file.scene.gravity[2], -1);
  EXPECT_EQ(file.scene.materials[0].damping_mass, 3);
  EXPECT_EQ(file.scene.name, "a=b");
  EXPECT_EQ(file.scene.cloths[0].mesh.triangles.size(), 2u * 4u * 2u);
  EXPECT_EQ(file.scene.solver.newton_iterations, 2000);
  EXPECT_EQ(file.resolved.at("time").at("step"), 0.002);
  // the last of two counts
  EXPECT_EQ(read_scene(path, {"time.frames=3", "time.frames=4"}).time.frames, 4);
}

TEST_F(SceneFileTest, WrongOverrides) {
  const auto path = put("a.json", minimal().dump());
  const std::vector<std::array<std::string, 3>> cases{
      {"time.stepp=1", "time.stepp: ", "did you mean \"step\"?"},
      {"tiem.step=1", "tiem: ", "did you mean \"time\"?"},
      {"cloths.1.material=cotton", "--set cloths.1: ", "0, the only place in cloths"},
      {"cloths.x.material=cotton", "--set cloths.x: ", "\"x\""},
      {"cloths.0.material.name=cotton", "--set cloths.0.material.name: ", "\"cotton\""},
      {"time.step", "--set: ", "\"time.step\""},
      {"=5", "--set: ", "\"=5\""},
      {"time..step=5", "--set: ", "\"time..step=5\""},
      {"time.step=fast", "time.step: ", "\"fast\""},
      {"time.step=nan", "time.step: ", "\"nan\""},
      {"time.step=1e999", "time.step: ", "\"1e999\""},
      {"time.step=", "time.step: ", "\"\""},
      {"name=\xff", "name: ", "UTF-8"},
      {"triangles=500", "triangles: ", "500"},
  };
  for (const auto& [text, field, value] : cases) {
    try {
      read_scene(path, {text});
      ADD_FAILURE() << text << " was accepted";
    } catch (const SceneError& error) {
      const std::string what = error.what();
      EXPECT_EQ(what.find(path.string() + ": " + field), 0u) << what;
      EXPECT_NE(what.find(value), std::string::npos) << what;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
  }
}

TEST_F(SceneFileTest, EveryTruncationIsRefused) {
  const std::string text = minimal().dump(1);
  for (std::size_t n = 0; n + 1 < text.size(); ++n)
    EXPECT_THROW(read_scene(put("a.json", text.substr(0, n))), SceneError) << n << " bytes";
}

TEST_F(SceneFileTest, ExtremesEndInAMessage) {
  for (const char* text :
       {"cloths.0.grid.size=[1e-300, 1e-300]", "cloths.0.grid.size=[1e300, 1e300]",
        "cloths.0.transform={\"scale\": 1e-200}", "cloths.0.copies={\"count\": 10001}",
        "obstacles=[{\"sphere\": {\"radius\": 1e-320}}]", "time.frames=1e10",
        "cloths.0.grid={\"size\": [1e9, 1e-9], \"cells\": [2000000, 2000000]}"})
    EXPECT_THROW(read_scene(put("a.json", minimal().dump()), {text}), SceneError) << text;
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  try {
    read_scene(put("deep.json", deep));
    ADD_FAILURE();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("deep.json: nested"), std::string::npos);
  }
  EXPECT_THROW(read_scene(directory_ / "none.json"), SceneError);
  EXPECT_THROW(read_scene(directory_), SceneError);
}

TEST(NearestWord, FindsSlipsOnly) {
  EXPECT_EQ(nearest_word("thicknes", {"thickness", "friction"}), "thickness");
  EXPECT_EQ(nearest_word("fricton", {"thickness", "friction"}), "friction");
  EXPECT_EQ(nearest_word("wind", {"thickness", "friction"}), std::nullopt);
  EXPECT_EQ(nearest_word("xy", {"ab"}), std::nullopt);
  EXPECT_EQ(nearest_word("--out", {"--device", "--output"}), "--output");
  EXPECT_EQ(nearest_word("out", {"output"}), std::nullopt);
  EXPECT_EQ(nearest_word("--obdy", {"--only", "--body"}), "--body");
}

}  // namespace
}  // namespace weft::io
