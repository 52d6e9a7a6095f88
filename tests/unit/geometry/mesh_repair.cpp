#include "host/geometry/mesh_repair.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host/geometry/mesh_check.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

Mesh square() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
  return mesh;
}

void expect_sound(const Mesh& mesh, bool with_material = false) {
  EXPECT_NO_THROW(check_mesh(mesh, {"a.obj", "mesh", ""}, with_material));
}

TEST(Repair, LeavesASoundMeshAlone) {
  Mesh mesh = square();
  EXPECT_EQ(repair_mesh(mesh), "");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.triangles.size(), 2u);
}

TEST(Repair, JoinsVerticesAndKeepsTheirMaterialCoordinates) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.material = {{0, 0}, {1, 0}, {1, 1}, {5, 0}, {6, 1}, {5, 1}};
  mesh.triangles = {{{0, 1, 2}}, {{3, 4, 5}}};
  EXPECT_EQ(repair_mesh(mesh), "joined 2 vertices");
  ASSERT_EQ(mesh.positions.size(), 4u);
  ASSERT_EQ(mesh.material_triangles.size(), 2u);
  const auto corner = static_cast<std::size_t>(mesh.material_triangles[1].v[0]);
  EXPECT_EQ(mesh.material.at(corner)[0], 5);
  expect_sound(mesh, true);
}

TEST(Repair, DropsWhatHasNoAreaIsThereTwiceOrAlone) {
  Mesh mesh = square();
  mesh.positions.push_back({9, 9, 9});
  mesh.positions.push_back({2, 2, 0});
  mesh.triangles.push_back({{0, 2, 5}});
  mesh.triangles.push_back({{1, 2, 0}});
  EXPECT_EQ(repair_mesh(mesh),
            "dropped 1 triangle without area; dropped 1 duplicate triangle; dropped 2 isolated "
            "vertices");
  EXPECT_EQ(mesh.triangles.size(), 2u);
  expect_sound(mesh);
}

TEST(Repair, LeavesTwoTrianglesAnEdgeAndTurnsThemOneWay) {
  Mesh mesh = square();
  mesh.positions.push_back({0.5, 0.5, 1});
  mesh.triangles.push_back({{0, 2, 4}});
  mesh.positions.push_back({2, 0.5, 0});
  mesh.triangles.push_back({{1, 2, 5}});
  EXPECT_EQ(repair_mesh(mesh),
            "dropped 1 triangle beyond two at an edge; turned 1 triangle; dropped 1 isolated "
            "vertex");
  expect_sound(mesh);
}

TEST(Repair, OrientsBySignOfMaterialArea) {
  Mesh mesh = square();
  mesh.material = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (Tri& t : mesh.triangles) std::swap(t.v[1], t.v[2]);
  EXPECT_EQ(repair_mesh(mesh), "turned 2 triangles");
  expect_sound(mesh, true);
}

/// A grid of 4 x 4 cells whose vertices of column `moved` lie `gap` cells right of those before.
Mesh grid_with_needles(Index moved, double gap) {
  Mesh mesh = make_grid({4, 4}, {4, 4}, Diagonals::alternating);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (std::abs(mesh.material[v][0] - (moved - 2)) > 0.1) continue;
    mesh.material[v][0] = mesh.positions[v][0] = moved - 3 + gap;
  }
  return mesh;
}

double material_area(const Mesh& mesh) {
  double area = 0;
  for (const Tri& t : mesh.triangles) {
    const auto at = [&](int j) { return mesh.material[static_cast<std::size_t>(t.v[j])]; };
    const Vec2<double> a = at(1) - at(0), b = at(2) - at(0);
    area += (a[0] * b[1] - a[1] * b[0]) / 2;
  }
  return area;
}

TEST(Repair, CollapsesNeedlesAndKeepsTheOutline) {
  for (const Index moved : {1, 2, 4})
    for (const double gap : {1e-5, 1e-9}) {  // the latter have no area
      Mesh mesh = grid_with_needles(moved, gap);
      // All of the right-hand column is moved to the one before: there the outline is shorter.
      const double width = moved == 4 ? 3 + gap : 4;
      EXPECT_EQ(repair_mesh(mesh, repaired_height), "collapsed 5 short edges of slivers") << moved;
      expect_sound(mesh, true);
      EXPECT_NO_THROW(check_slivers(mesh, {"a.obj", "mesh", ""}, repaired_height));
      EXPECT_EQ(mesh.triangles.size(), 24u);
      EXPECT_EQ(mesh.positions.size(), 20u);
      EXPECT_NEAR(material_area(mesh), 4 * width, 1e-12);
    }
}

TEST(Repair, LeavesNeedlesUnlessAsked) {
  Mesh mesh = grid_with_needles(2, 1e-5);
  EXPECT_EQ(repair_mesh(mesh), "");
  EXPECT_THROW(
      check_slivers(mesh, {"a.obj", "mesh", ""}, least_height(Precision::single_precision)),
      SceneError);
  EXPECT_NO_THROW(
      check_slivers(mesh, {"a.obj", "mesh", ""}, least_height(Precision::double_precision)));
}

TEST(Repair, FlipsCapsAndDropsThoseOfTheOutline) {
  // The middle vertex of a square lies next to its diagonal: the cap there is flipped.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5 + 1e-5, 0}};
  mesh.triangles = {{{0, 1, 2}}, {{0, 2, 4}}, {{2, 3, 4}}, {{3, 0, 4}}};
  Mesh flat = mesh;
  flat.positions[4] = {0.5, 0.5, 0};
  EXPECT_EQ(repair_mesh(flat, repaired_height), "flipped 1 long edge of a sliver");
  expect_sound(flat);
  EXPECT_EQ(repair_mesh(mesh, repaired_height), "flipped 1 long edge of a sliver");
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.positions.size(), 5u);
  expect_sound(mesh);

  // Without the triangle below, its long edge is the outline.
  mesh.positions = {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5 + 1e-5, 0}};
  mesh.triangles = {{{0, 1, 3}}, {{1, 2, 3}}, {{2, 0, 3}}};
  EXPECT_EQ(repair_mesh(mesh, repaired_height), "dropped 1 sliver of the outline");
  EXPECT_EQ(mesh.triangles.size(), 2u);
  expect_sound(mesh);
}

TEST(Repair, LeavesSliversThatNoChangeTakesAway) {
  // Both ends of the short edge are on the outline, in two parts of it: the sheet would be pinched.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 1e-5, 0}, {-1, -1, 0}, {-1, 1, 0}, {1, -1, 0}, {1, 1, 0}};
  mesh.triangles = {{{0, 1, 2}}, {{1, 3, 2}}, {{1, 0, 4}}, {{4, 5, 1}}};
  const Mesh before = mesh;
  EXPECT_EQ(repair_mesh(mesh, repaired_height), "");
  EXPECT_EQ(mesh.triangles.size(), before.triangles.size());
}

TEST(Repair, CutsAOneSidedStrip) {
  Mesh mesh;
  for (int i = 0; i < 5; ++i) {
    mesh.positions.push_back({static_cast<double>(i), static_cast<double>(i * i), 0});
    const auto next = [&](int k) { return static_cast<Index>((i + k) % 5); };
    mesh.triangles.push_back({{next(0), next(1), next(2)}});
  }
  EXPECT_NE(repair_mesh(mesh).find("of a one-sided part"), std::string::npos);
  expect_sound(mesh);
}

}  // namespace
}  // namespace weft::io
