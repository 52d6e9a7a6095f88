#include "host/model/model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "host/state/energy.hpp"
#include "weft/elements/hinge.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

/// A tube of 6 x 2 cells, sewn along one line of its pattern.
Scene tube() {
  Scene scene;
  scene.bending = Bending::hinge;
  scene.materials.resize(2);
  scene.materials[0] = {"light", 0.1, 1000, 0.3, 1e-5, 0, 0};
  scene.materials[1] = {"heavy", 0.3, 1000, 0.3, 5e-5, 0, 0};
  scene.cloths.resize(1);
  scene.cloths[0].mesh = make_tube(0.5, 1, {6, 2});
  return scene;
}

double pattern_area() {
  return 6 * 0.5 * 1;  // a hexagon's sides are as long as its radius
}

TEST(Model, PatternSeams) {
  const Scene scene = tube();
  ASSERT_FALSE(scene.cloths[0].mesh.material_triangles.empty());
  const Model model = make_model(scene);
  EXPECT_NEAR(std::accumulate(model.area.begin(), model.area.end(), 0.0), pattern_area(), 1e-12);
  EXPECT_NEAR(std::accumulate(model.mass.begin(), model.mass.end(), 0.0), 0.1 * pattern_area(),
              1e-12);
  // 24 triangles have 72 sides, 12 of them on the rims: the others meet in hinges, the seam's too.
  EXPECT_EQ(model.hinges.size(), 30u);
  for (const double c : model.hinge_stiffness) {
    // edges of 0.5 m, or diagonals of sqrt(0.5) m, between triangles of 0.125 m^2
    const bool side = std::abs(c / hinge_coefficient(1e-5, 0.5, 0.25) - 1) < 1e-9;
    const bool diagonal = std::abs(c / hinge_coefficient(1e-5, std::sqrt(0.5), 0.25) - 1) < 1e-9;
    EXPECT_TRUE(side || diagonal) << c;
  }
  Scene soft = scene;
  soft.materials[0].bending_stiffness = 0;
  soft.gravity = {0, 0, 0};
  const std::vector<Vec3<double>> rest(model.positions.size(), Vec3<double>{0, 0, 0});
  EXPECT_NEAR(measure_energy(soft, make_model(soft), model.positions, rest).elastic, 0, 1e-20);
}

TEST(Model, PiecesThatLieOnEachOtherInTheFileAreApart) {
  Scene scene = tube();
  Mesh& mesh = scene.cloths[0].mesh;
  mesh = {};
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}};
  mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
  mesh.material = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 0}, {1, 1}};
  mesh.material_triangles = {{{0, 1, 2}}, {{3, 4, 5}}};
  const Model model = make_model(scene);
  const auto at = [&](std::size_t input) {
    return model.material_points[static_cast<std::size_t>(model.to_internal[input])];
  };
  EXPECT_NEAR(length(at(1) - at(0)), 1, 1e-15);
  EXPECT_GT(length(at(3) - at(2)), 1);
}

TEST(Model, EdgesAcrossASeamOfThePatternAreCut) {
  const Model model = make_model(tube());
  ASSERT_EQ(model.cut.size(), static_cast<std::size_t>(model.cloth_edge_count));
  int cut = 0;
  for (std::size_t e = 0; e < model.cut.size(); ++e) {
    // The seam is along the column of the first vertex; the cells before it reach across.
    Index column[2];
    for (int j = 0; j < 2; ++j)
      column[j] = model.to_input[static_cast<std::size_t>(model.edges[e].v[j])] % 6;
    const bool across = std::abs(column[1] - column[0]) == 5;
    EXPECT_EQ(model.cut[e] != 0, across) << column[0] << " " << column[1];
    cut += across ? 1 : 0;
  }
  EXPECT_EQ(cut, 3 + 2);  // those around and the diagonals of two cells
}

TEST(Model, FlatClothHasNoCutEdges) {
  Scene scene = tube();
  scene.cloths[0].mesh = make_grid({1, 1}, {4, 3}, Diagonals::same);
  EXPECT_TRUE(make_model(scene).cut.empty());
}

TEST(Model, MaterialsOfTriangles) {
  Scene scene = tube();
  scene.cloths[0].triangle_material.assign(24, 0);
  for (std::size_t t = 0; t < 12; ++t) scene.cloths[0].triangle_material[t] = 1;
  const Model model = make_model(scene);
  EXPECT_NEAR(std::accumulate(model.mass.begin(), model.mass.end(), 0.0),
              (0.1 + 0.3) / 2 * pattern_area(), 1e-12);
  std::size_t between = 0;
  for (const double c : model.hinge_stiffness)
    if (std::abs(c / hinge_coefficient(3e-5, 0.5, 0.25) - 1) < 1e-9) ++between;
  EXPECT_EQ(between, 6u);  // the ring between the two rows of cells
  scene.cloths[0].triangle_material[3] = 2;
  EXPECT_THROW(make_model(scene), SceneError);
  scene.cloths[0].triangle_material.pop_back();
  EXPECT_THROW(make_model(scene), SceneError);
}

TEST(Model, AngularVelocity) {
  Scene scene = tube();
  scene.cloths[0].velocity = {1, 0, 0};
  scene.cloths[0].angular_velocity = {0, 0, 2};
  scene.cloths[0].velocity_origin = {0, 0, 7};
  const Model model = make_model(scene);
  for (std::size_t v = 0; v < model.velocities.size(); ++v) {
    EXPECT_NEAR(model.velocities[v][0], 1 - 2 * model.positions[v][1], 1e-14);
    EXPECT_NEAR(model.velocities[v][1], 2 * model.positions[v][0], 1e-14);
  }
}

}  // namespace
}  // namespace weft
