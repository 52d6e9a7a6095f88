#include <gtest/gtest.h>

#include <cmath>

#include "host/io/scene/scene_file.hpp"
#include "host/scene/fabric/fabrics.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

class SceneMaterialsTest : public DirectoryTest {
 protected:
  SceneFile read(const json& material) {
    const json scene{
        {"materials", {{"cotton", material}}},
        {"cloths", {{{"grid", {{"size", {1, 1}}, {"cells", {2, 2}}}}, {"material", "cotton"}}}}};
    return read_scene_file(put("scene.json", scene.dump()));
  }
  Material material(const json& m) {
    const SceneFile file = read(m);
    // what is written down says the same when it is read
    const SceneFile again = read_scene_file(put("again.json", file.resolved.dump()));
    EXPECT_EQ(again.resolved, file.resolved);
    return file.scene.materials.at(0);
  }
};

TEST_F(SceneMaterialsTest, Threads) {
  const Material m = material(
      {{"orthotropic",
        {{"stretch_stiffness", {900, 300}}, {"poisson_ratio", 0.4}, {"shear_stiffness", 50}}},
       {"orthotropic_bending", {{"stiffness", {8e-5, 2e-5}}}}});
  ASSERT_TRUE(m.orthotropic);
  EXPECT_EQ(m.orthotropic->warp, 900);
  EXPECT_EQ(m.orthotropic->weft, 300);
  EXPECT_EQ(m.orthotropic->poisson_ratio, 0.4);
  EXPECT_EQ(m.orthotropic->shear, 50);
  ASSERT_TRUE(m.orthotropic_bending);
  EXPECT_EQ(m.orthotropic_bending->warp, 8e-5);
  EXPECT_EQ(m.orthotropic_bending->weft, 2e-5);
  EXPECT_NEAR(m.orthotropic_bending->coupling, 0.8e-5, 1e-18);
  EXPECT_NEAR(m.orthotropic_bending->twist, (4e-5 - 0.8e-5) / 2, 1e-18);
  const Material given = material(
      {{"orthotropic_bending", {{"stiffness", {8e-5, 2e-5}}, {"coupling", 0}, {"twist", 1e-6}}}});
  EXPECT_FALSE(given.orthotropic);
  EXPECT_EQ(given.stretch_stiffness, Material{}.stretch_stiffness);
  EXPECT_EQ(given.orthotropic_bending->coupling, 0);
  EXPECT_EQ(given.orthotropic_bending->twist, 1e-6);
}

TEST_F(SceneMaterialsTest, StrainLimits) {
  EXPECT_FALSE(material(json::object()).strain_limits);
  const Material m = material({{"strain_limits", {0.95, 1.1}}});
  ASSERT_TRUE(m.strain_limits);
  EXPECT_EQ(m.strain_limits->min, 0.95);
  EXPECT_EQ(m.strain_limits->max, 1.1);
  EXPECT_EQ(material({{"strain_limits", {0, 1.1}}}).strain_limits->min, 0);
}

TEST_F(SceneMaterialsTest, Fabrics) {
  for (const Fabric& fabric : fabrics()) {
    const Material m = material({{"fabric", fabric.name}});
    EXPECT_EQ(m.name, "cotton");
    EXPECT_EQ(m.density, fabric.material.density);
    ASSERT_TRUE(m.orthotropic && m.orthotropic_bending);
    EXPECT_EQ(m.orthotropic->warp, fabric.material.orthotropic->warp);
    EXPECT_EQ(m.orthotropic->shear, fabric.material.orthotropic->shear);
    EXPECT_EQ(m.orthotropic_bending->twist, fabric.material.orthotropic_bending->twist);
  }
}

/// A cloth may name a fabric itself, or nothing.
TEST_F(SceneMaterialsTest, ClothsNameFabrics) {
  const json grid{{"size", {1, 1}}, {"cells", {2, 2}}};
  const json scene{
      {"materials",
       {{"silk", {{"fabric", "silk"}}}, {"wool", {{"fabric", "wool"}, {"density", 1}}}}},
      {"cloths",
       {{{"grid", grid}, {"fabric", "silk"}},
        {{"grid", grid}, {"fabric", "wool"}, {"transform", {{"translate", {0, 0, 1}}}}},
        {{"grid", grid}, {"transform", {{"translate", {0, 0, 2}}}}}}}};
  const SceneFile file = read_scene_file(put("scene.json", scene.dump()));
  const auto of_cloth = [&](std::size_t c) {
    return file.scene.materials.at(static_cast<std::size_t>(file.scene.cloths.at(c).material));
  };
  EXPECT_EQ(of_cloth(0).name, "silk");
  EXPECT_EQ(of_cloth(1).name, "wool_fabric") << "the scene's own wool is another one";
  EXPECT_EQ(of_cloth(1).density, find_fabric("wool")->material.density);
  EXPECT_EQ(of_cloth(2).name, default_fabric);
  EXPECT_EQ(of_cloth(2).density, find_fabric(default_fabric)->material.density);
  ASSERT_EQ(file.scene.warnings.size(), 1u);
  EXPECT_TRUE(file.scene.warnings[0].starts_with("cloths[2]: ")) << file.scene.warnings[0];
  const SceneFile again = read_scene_file(put("again.json", file.resolved.dump()));
  EXPECT_EQ(again.resolved, file.resolved);
  EXPECT_TRUE(again.scene.warnings.empty());
}

TEST_F(SceneMaterialsTest, NoMaterialsAreTheDefaultFabric) {
  const json scene{{"cloths", {{{"grid", {{"size", {1, 1}}, {"cells", {2, 2}}}}}}}};
  const SceneFile file = read_scene_file(put("scene.json", scene.dump()));
  ASSERT_EQ(file.scene.materials.size(), 1u);
  EXPECT_EQ(file.scene.materials[0].name, default_fabric);
  EXPECT_TRUE(file.scene.warnings.empty());
  EXPECT_EQ(file.resolved.at("cloths")[0].at("material"), default_fabric);
}

TEST_F(SceneMaterialsTest, KeysBesideAFabricReplaceItsOwn) {
  const Material heavy = material({{"fabric", "denim"}, {"density", 0.4}});
  EXPECT_EQ(heavy.density, 0.4);
  EXPECT_TRUE(heavy.orthotropic);
  const Material plain = material({{"fabric", "denim"}, {"stretch_stiffness", 700}});
  EXPECT_FALSE(plain.orthotropic);
  EXPECT_EQ(plain.stretch_stiffness, 700);
  EXPECT_TRUE(plain.orthotropic_bending);
  const Material limp = material({{"fabric", "denim"}, {"bending_stiffness", 1e-7}});
  EXPECT_TRUE(limp.orthotropic);
  EXPECT_FALSE(limp.orthotropic_bending);
  json rows = json::array();
  for (int i = 0; i < 6; ++i) rows.push_back({50, 8, 240, 3});
  const Material measured = material({{"fabric", "denim"}, {"measured", {{"stretching", rows}}}});
  EXPECT_TRUE(measured.measured);
  EXPECT_FALSE(measured.orthotropic);
}

TEST_F(SceneMaterialsTest, MeasuredTables) {
  json rows = json::array();
  for (int i = 0; i < 6; ++i) rows.push_back({50 + i, 8, 240, -3});
  const Material m = material({{"measured", {{"stretching", rows}}}, {"bending_stiffness", 2e-5}});
  ASSERT_TRUE(m.measured);
  EXPECT_EQ(m.measured->form, MeasuredStretch::Form::energy);
  EXPECT_EQ(m.measured->rows[5], (std::array<double, 4>{55, 8, 240, -3}));
  EXPECT_EQ(m.bending_stiffness, 2e-5);
  const Material as_arcsim =
      material({{"measured", {{"stretching", rows}, {"form", "wang_arcsim"}}}});
  EXPECT_EQ(as_arcsim.measured->form, MeasuredStretch::Form::arcsim);
}

}  // namespace
}  // namespace weft::io
