#include "host/geometry/mesh_check.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

Mesh square() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
          {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
          {{{0, 1, 2}}, {{0, 2, 3}}}};
}

std::string refusal(const Mesh& mesh, bool needs_material = true) {
  try {
    check_mesh(mesh, {"a.obj", "cloths[2].mesh", "shirt"}, needs_material);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

struct Case {
  const char* name;
  std::function<void(Mesh&)> spoil;
  const char* field;
  const char* value;
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"no vertices", [](Mesh& m) { m = {}; }, "positions", "no vertices"},
      {"no triangles", [](Mesh& m) { m.triangles.clear(); }, "triangles", "no triangles"},
      {"no material", [](Mesh& m) { m.material.clear(); }, "material", "no material"},
      {"short material", [](Mesh& m) { m.material.pop_back(); }, "material", "3 pairs"},
      {"nan", [](Mesh& m) { m.positions[2][1] = nan; }, "positions", "vertex 2: nan"},
      {"inf", [](Mesh& m) { m.positions[3][0] = -inf; }, "positions", "vertex 3: inf"},
      {"material nan", [](Mesh& m) { m.material[1][1] = nan; }, "material", "vertex 1: nan"},
      {"index", [](Mesh& m) { m.triangles[1].v[2] = 4; }, "triangles", "triangle 1: vertex 4"},
      {"negative", [](Mesh& m) { m.triangles[0].v[0] = -1; }, "triangles", "triangle 0: vertex -1"},
      {"repeated", [](Mesh& m) { m.triangles[1].v[2] = 2; }, "triangles",
       "corner repeated (triangle 1)"},
      {"isolated",
       [](Mesh& m) {
         m.positions.push_back({5, 5, 5});
         m.material.push_back({5, 5});
       },
       "positions", "isolated vertex (vertex 4)"},
      {"duplicate",
       [](Mesh& m) {
         m.triangles.push_back({{2, 0, 1}});
       },
       "triangles", "duplicate triangle (triangle 2 like 0)"},
      {"mirrored duplicate",
       [](Mesh& m) {
         m.triangles.push_back({{1, 0, 2}});
       },
       "triangles", "duplicate triangle (triangle 2 like 0)"},
      {"three on an edge",
       [](Mesh& m) {
         m.positions.push_back({0, 0, 1});
         m.material.push_back({-1, 2});
         m.triangles.push_back({{0, 2, 4}});
       },
       "triangles", "non-manifold edge (edge 0-2 of triangles 0 1 2)"},
      {"flipped",
       [](Mesh& m) {
         m.triangles[1] = {{0, 3, 2}};
       },
       "triangles", "against its neighbour (triangle 1 beside 0)"},
      {"flat in the world",
       [](Mesh& m) {
         m.positions[3] = {0.5, 0.5, 0};
       },
       "triangles", "zero area in world space (triangle 1)"},
      {"nearly flat",
       [](Mesh& m) {
         m.positions[3] = {0.5, 0.5 + 1e-9, 0};
       },
       "triangles", "zero area in world space (triangle 1)"},
      {"out of range",
       [](Mesh& m) {
         m.positions[3] = {0.5, 1e39, 0};
       },
       "positions", "coordinates out of range (vertex 3: 1e39)"},
      {"flat in material",
       [](Mesh& m) {
         m.material[3] = {0.5, 0.5};
       },
       "material", "zero area in material space (triangle 1)"},
      {"material out of range",
       [](Mesh& m) {
         m.material[3] = {0.5, 1e39};
       },
       "material", "coordinates out of range (vertex 3: 1e39)"},
      {"inverted",
       [](Mesh& m) {
         m.material[3] = {1, 0.5};
       },
       "material", "inverted in material space (triangle 1)"},
  };
  return all;
}

TEST(MeshCheck, AcceptsAGoodMesh) {
  EXPECT_EQ(refusal(square()), "");
  EXPECT_EQ(refusal(make_grid({1, 1}, {20, 30}, Diagonals::alternating)), "");
}

TEST(MeshCheck, RefusesEachDefectByName) {
  for (const Case& c : cases()) {
    Mesh mesh = square();
    c.spoil(mesh);
    const std::string message = refusal(mesh);
    EXPECT_NE(message.find(std::string("a.obj: cloths[2].mesh.") + c.field), std::string::npos)
        << c.name << ": " << message;
    EXPECT_NE(message.find(c.value), std::string::npos) << c.name << ": " << message;
    EXPECT_NE(message.find("\"shirt\""), std::string::npos) << c.name << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << c.name;
  }
}

TEST(MeshCheck, MaterialIsForClothOnly) {
  Mesh mesh = square();
  mesh.material.clear();
  EXPECT_EQ(refusal(mesh, false), "");
}

TEST(MeshCheck, ListsTheFirstFewOfMany) {
  Mesh mesh = make_grid({1, 1}, {10, 10}, Diagonals::same);
  for (Vec2<double>& u : mesh.material) u[0] = -u[0];
  EXPECT_NE(refusal(mesh).find("triangles 0, 1, 2, 3, 4 and 195 more"), std::string::npos)
      << refusal(mesh);
}

TEST(MeshCheck, ThinTrianglesAreFine) {
  Mesh mesh = make_grid({1, 1e-5}, {1, 1}, Diagonals::same);
  EXPECT_EQ(refusal(mesh), "");
}

}  // namespace
}  // namespace weft
