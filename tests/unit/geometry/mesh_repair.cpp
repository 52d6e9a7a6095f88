#include "host/geometry/mesh_repair.hpp"

#include <gtest/gtest.h>

#include "host/geometry/mesh_check.hpp"
#include "weft/error.hpp"

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
