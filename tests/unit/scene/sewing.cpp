#include "host/scene/seams/sewing.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "host/model/model.hpp"
#include "host/model/refine.hpp"
#include "host/scene/intersection_check.hpp"
#include "host/state/transfer.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Two sheets side by side, `gap` apart, sewn along their common side of 4 vertices.
Scene two_panels(double gap) {
  Scene s;
  s.bending = Bending::hinge;
  s.materials.push_back(test::cotton());
  for (int k = 0; k < 2; ++k) s.cloths.push_back(test::sheet(3, 0));
  for (auto& p : s.cloths[1].mesh.positions) p[0] += 0.4 + gap;
  s.cloths[0].name = "left";
  s.cloths[1].name = "right";
  Seam seam;
  seam.cloths[1] = 1;
  for (Index j = 0; j < 4; ++j) {
    seam.vertices[0].push_back(4 * j + 3);
    seam.vertices[1].push_back(4 * j);
  }
  seam.weld_distance = 1e-3;
  s.seams.push_back(seam);
  return s;
}

TEST(Sewing, GroupsGoByWayOfOthers) {
  const std::vector<Index> expected{0, 1, 0, 3, 0, 1};
  EXPECT_EQ(expected, grouped(6, {{{4, 2}, 0}, {{5, 1}, 0}, {{2, 0}, 0}}));
}

TEST(Sewing, StartsWithThePairsThatAreCloseEnough) {
  EXPECT_TRUE(sewing_at_start(two_panels(0.9e-3)).complete());
  Scene s = two_panels(1.1e-3);
  EXPECT_EQ(std::vector<unsigned char>(4, 0), sewing_at_start(s).welded);
  s.cloths[1].mesh.positions[4][0] -= 5e-4;
  EXPECT_EQ((std::vector<unsigned char>{0, 1, 0, 0}), sewing_at_start(s).welded);
  s = two_panels(0);
  s.seams[0].weld_distance = 0;
  EXPECT_EQ(std::vector<unsigned char>(4, 0), sewing_at_start(s).welded);
  EXPECT_FALSE(Sewing{}.complete());
}

TEST(Sewing, WeldedVerticesAreOneInTheModel) {
  const Scene s = two_panels(5e-4);
  const Model apart = make_model(s);
  const Model sewn = make_model(s, {1, 1, 1, 1});
  EXPECT_EQ(32, apart.cloth_vertex_count);
  EXPECT_EQ(28, sewn.cloth_vertex_count);
  EXPECT_EQ(apart.cloth_triangle_count, sewn.cloth_triangle_count);
  // Three edges became one with their partners; each is now inside, where it bends.
  EXPECT_EQ(apart.edges.size(), sewn.edges.size() + 3);
  EXPECT_EQ(apart.hinges.size() + 3, sewn.hinges.size());
  EXPECT_NEAR(std::accumulate(apart.mass.begin(), apart.mass.end(), 0.0),
              std::accumulate(sewn.mass.begin(), sewn.mass.end(), 0.0), 1e-15);
  for (std::size_t k = 0; k < 4; ++k) {
    const Index v = sewn.to_internal[at(s.seams[0].vertices[0][k])];
    EXPECT_EQ(v, sewn.to_internal[16 + at(s.seams[0].vertices[1][k])]);
    EXPECT_NEAR(0.2 + 2.5e-4, sewn.positions[at(v)][0], 1e-15);  // midway
    EXPECT_EQ(v, sewn.tied[at(v)]);
  }
  // Apart they are tied, so that the panels do not repel each other there.
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_EQ(apart.tied[at(apart.to_internal[at(s.seams[0].vertices[0][k])])],
              apart.tied[at(apart.to_internal[16 + at(s.seams[0].vertices[1][k])])]);
}

TEST(Sewing, PanelsThatTouchWhereTheyAreWeldedDoNotTangle) {
  const Scene s = two_panels(0);
  EXPECT_THROW(refuse_intersecting_start(s), SceneError);
  EXPECT_NO_THROW(refuse_intersecting_start(s, {1, 1, 1, 1}));
  EXPECT_THROW(refuse_intersecting_start(s, {1, 1, 0, 1}), SceneError);
}

TEST(Sewing, MergingKeepsMomentumAndObeysPins) {
  const Scene s = two_panels(5e-4);
  const Model model = make_model(s);
  StateSnapshot<double> state;
  state.positions = model.positions;
  state.velocities = model.velocities;
  for (std::size_t v = 0; v < state.velocities.size(); ++v)
    state.velocities[v] = {0.1 * static_cast<double>(v), 1 - 0.2 * static_cast<double>(v % 7), 0};
  state.previous_positions = state.positions;
  for (std::size_t v = 0; v < state.positions.size(); ++v)
    state.previous_positions[v] -= 0.01 * state.velocities[v];
  state.previous_velocities = state.velocities;
  state.touched.assign(state.positions.size(), 0);
  state.touched[at(model.to_internal[16])] = 9;
  const auto sum = [&](const std::vector<Vec3<double>>& values) {
    Vec3<double> total{};
    for (std::size_t v = 0; v < model.mass.size(); ++v) total += model.mass[v] * values[v];
    return total;
  };
  std::vector<unsigned char> fixed(model.positions.size(), 0);
  const auto merged = merged_state(model, model.tied, fixed, state);
  EXPECT_LT(length(sum(merged.velocities) - sum(state.velocities)), 1e-15);
  EXPECT_LT(length(sum(merged.positions) - sum(state.positions)), 1e-15);
  const auto a = at(model.to_internal[3]);
  const auto b = at(model.to_internal[16]);
  EXPECT_EQ(merged.positions[a], merged.positions[b]);
  EXPECT_EQ(merged.velocities[a], merged.velocities[b]);
  // The way to the common place is not part of the last step's motion.
  EXPECT_LT(length(sum(merged.previous_velocities) - sum(state.velocities)), 1e-15);
  EXPECT_LT(
      length(merged.positions[a] - merged.previous_positions[a] - 0.01 * merged.velocities[a]),
      1e-15);
  EXPECT_EQ(merged.touched[a], 9);
  EXPECT_EQ(merged.touched[b], 9);
  fixed[b] = 1;
  const auto held = merged_state(model, model.tied, fixed, state);
  EXPECT_EQ(held.positions[a], state.positions[b]);
  EXPECT_EQ(held.velocities[a], state.velocities[b]);
  EXPECT_EQ(held.previous_positions[a], state.previous_positions[b]);
}

double area_in_material(const Mesh& mesh) {
  double sum = 0;
  const auto& corners = mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  for (const Tri& t : corners) {
    const auto p = mesh.material[at(t.v[0])];
    const auto a = mesh.material[at(t.v[1])] - p;
    const auto b = mesh.material[at(t.v[2])] - p;
    EXPECT_GT(a[0] * b[1] - a[1] * b[0], 0);
    sum += (a[0] * b[1] - a[1] * b[0]) / 2;
  }
  return sum;
}

TEST(Refine, SplitsEveryTriangleIntoFour) {
  Mesh mesh = test::sheet(3, 0).mesh;
  mesh.group.assign(mesh.triangles.size(), 0);
  mesh.group.back() = 1;
  mesh.group_names = {"body", "corner"};
  const RefinedMesh refined = refine_mesh(mesh);
  EXPECT_EQ(4 * mesh.triangles.size(), refined.mesh.triangles.size());
  EXPECT_EQ(49u, refined.mesh.positions.size());  // a grid of 6 cells has as many
  EXPECT_NEAR(area_in_material(mesh), area_in_material(refined.mesh), 1e-15);
  for (std::size_t v = 0; v < refined.parents.size(); ++v) {
    const auto [a, b] = refined.parents[v];
    EXPECT_LT(
        length(refined.mesh.positions[v] - 0.5 * (mesh.positions[at(a)] + mesh.positions[at(b)])),
        1e-16);
    EXPECT_EQ(v < mesh.positions.size(), a == b && at(a) == v);
  }
  EXPECT_EQ(1, refined.mesh.group.back());
  EXPECT_EQ(0, refined.mesh.group[refined.mesh.group.size() - 5]);
}

TEST(Refine, KeepsPiecesOfThePatternApart) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
  mesh.material = {{0, 0}, {1, 0}, {1, 1}, {5, 0}, {6, 1}, {5, 1}};
  mesh.material_triangles = {{{0, 1, 2}}, {{3, 4, 5}}};
  const RefinedMesh refined = refine_mesh(mesh);
  ASSERT_EQ(8u, refined.mesh.material_triangles.size());
  EXPECT_EQ(9u, refined.mesh.positions.size());
  EXPECT_EQ(12u, refined.mesh.material.size());
  EXPECT_NEAR(1, area_in_material(refined.mesh), 1e-15);
}

TEST(Refine, RestShapesAreCarriedAlong) {
  Scene s = two_panels(5e-4);
  s.seams.clear();
  s.cloths[1].rest_positions = s.cloths[1].mesh.positions;
  for (auto& x : s.cloths[1].rest_positions) x[2] = x[0] * x[0];
  const std::vector<Vec3<double>> before = s.cloths[1].rest_positions;
  s = refine_cloths(s, joined_inputs(s, {})).scene;
  EXPECT_TRUE(s.cloths[0].rest_positions.empty());
  const Cloth& cloth = s.cloths[1];
  const auto& after = cloth.rest_positions;
  ASSERT_EQ(cloth.mesh.positions.size(), after.size());
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_EQ(0, length(after[v] - before[v]));
  for (std::size_t v = before.size(); v < after.size(); ++v) {
    EXPECT_EQ(cloth.mesh.positions[v][0], after[v][0]);
    EXPECT_GE(after[v][2], after[v][0] * after[v][0] - 1e-15);  // on a chord
  }
  EXPECT_NO_THROW(make_model(s));
}

TEST(Refine, OfASewnSceneStaysSewn) {
  Scene s = two_panels(5e-4);
  s.pins.push_back({0, {0, 4, 2}, {}});
  s.cloths[0].triangle_material.assign(s.cloths[0].mesh.triangles.size(), 0);
  for (int level = 1; level <= 2; ++level) {
    s = refine_cloths(s, joined_inputs(s, std::vector<unsigned char>(seam_pairs(s).size(), 1)))
            .scene;
    const std::size_t pairs = level == 1 ? 7 : 13;
    ASSERT_EQ(pairs, seam_pairs(s).size());
    const Model model = make_model(s, std::vector<unsigned char>(pairs, 1));
    const std::size_t side = level == 1 ? 7 : 13;
    EXPECT_EQ(2 * side * side - side, model.to_input.size());
    EXPECT_EQ(side - 1, make_model(s).edges.size() - model.edges.size());
  }
  // Vertices 0 and 4 share an edge: the pin holds what lies between them, and nothing else.
  EXPECT_EQ(3u + 1 + 2, s.pins[0].vertices.size());
}

}  // namespace
}  // namespace weft
