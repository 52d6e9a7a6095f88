// Adaptive meshes: sizing, single operations, and whole passes that must keep what they promise.
#include "host/adaptive/remesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <vector>

#include "host/base/random.hpp"
#include "host/geometry/tensor.hpp"
#include "host/lab/check/validator.hpp"
#include "host/model/material_rows.hpp"
#include "tests/unit/adaptive/remesh_scenes.hpp"
#include "weft/elements/distance.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

// ---- sizing of faces

FaceShape flat_face() {
  FaceShape face{};
  face.deformation(0, 0) = face.deformation(1, 1) = 1;
  return face;
}

Remeshing fine_settings() {
  Remeshing s;
  s.size_min = 1e-4;
  s.size_max = 10;
  s.aspect_min = 0;
  return s;
}

TEST(RemeshSizing, CurvatureAllowsItsAngleAnEdge) {
  FaceShape face = flat_face();
  face.normals(0, 0) = 5;  // a radius of 0.2 m, bent along the first coordinate
  const Mat2<double> m = sizing_tensor(face, fine_settings());
  // 0.3 rad along an arc of radius 0.2 m are 0.06 m.
  EXPECT_NEAR(m(0, 0), 1 / (0.06 * 0.06), 1e-9);
  EXPECT_NEAR(m(1, 1), 0.01, 1e-12);
}

TEST(RemeshSizing, VelocityAllowsItsChangeAnEdge) {
  FaceShape face = flat_face();
  face.velocity(2, 1) = 10;
  EXPECT_NEAR(sizing_tensor(face, fine_settings())(1, 1), 1 / (0.05 * 0.05), 1e-9);
  Remeshing still = fine_settings();
  still.refine_velocity = infinity;
  EXPECT_NEAR(sizing_tensor(face, still)(1, 1), 0.01, 1e-12);
}

/// A grid as a surface for the remesher.
SurfaceMesh surface_of(const Mesh& mesh) {
  SurfaceMesh m;
  m.positions = m.starts = mesh.positions;
  m.velocities.assign(m.positions.size(), Vec3<double>{0, 0, 0});
  m.material = mesh.material;
  m.triangles = m.corners = mesh.triangles;
  m.kind.assign(mesh.triangles.size(), 0);
  m.kinds = {{0, 0, -1, 0.2}};
  m.hold.assign(m.positions.size(), 0);
  m.kept.assign(m.positions.size(), 0);
  m.heavy.assign(m.positions.size(), 0);
  for (Index v = 0; v < static_cast<Index>(m.positions.size()); ++v) {
    m.place.push_back(v);
    m.parents.push_back({v, v});
  }
  connect(m);
  m.metric.assign(m.material.size(), Mat2<double>::identity());
  return m;
}

TEST(RemeshSizing, AnEdgeIsAsLongAsTheMeanOfItsEndsTensors) {
  SurfaceMesh mesh;
  mesh.material = {{1, 2}, {1.3, 1.6}};
  mesh.metric = {{{100, 10, 10, 25}}, {{300, 30, 30, 75}}};
  // u = (0.3, -0.4): 200 * 0.09 - 2 * 20 * 0.12 + 50 * 0.16
  EXPECT_NEAR(edge_size(mesh, 0, 1), std::sqrt(18 - 4.8 + 8), 1e-14);
  EXPECT_EQ(edge_size(mesh, 1, 0), edge_size(mesh, 0, 1));
}

TEST(RemeshSizing, BentSheetAsksForItsRadius) {
  const double radius = 0.25;
  SurfaceMesh m = surface_of(make_grid({0.4, 0.4}, {32, 32}, Diagonals::alternating));
  for (std::size_t v = 0; v < m.positions.size(); ++v) {
    const double angle = m.material[v][0] / radius;
    m.positions[v] = {radius * std::sin(angle), m.material[v][1], radius * std::cos(angle)};
  }
  const Surroundings around;
  Remeshing s = fine_settings();
  s.refine_compression = infinity;
  set_metric(m, {s}, Clearance(m, around, 0.1), 0.1);
  const std::size_t centre = static_cast<std::size_t>(grid_vertex(32, 16, 16));
  // The normals give 1 / R exactly; angles at single edges scatter around it.
  EXPECT_NEAR(std::sqrt(m.metric[centre](0, 0)), 1 / (radius * 0.3), 0.1 / (radius * 0.3));
}

TEST(RemeshSizing, ObstacleAsksForItsDistanceAcrossOnly) {
  SurfaceMesh m = surface_of(make_grid({0.1, 0.1}, {1, 1}, Diagonals::same));
  // upright above a floor: one edge 0.01 m, the other 0.11 m from it
  for (std::size_t v = 0; v < 4; ++v)
    m.positions[v] = {m.material[v][0], 0, m.material[v][1] + 0.06};
  Surroundings around;
  around.positions = {{-5, -5, 0}, {5, -5, 0}, {0, 5, 0}};
  around.triangles = {{{0, 1, 2}}};
  Remeshing s = fine_settings();
  s.refine_compression = infinity;
  set_metric(m, {s}, Clearance(m, around, 0.05), 0.05);
  // Two triangles; the one with both low corners has 2/3 (1 / 0.01)^2, the other one 1/3.
  EXPECT_NEAR(m.metric[1](1, 1), 2.0 / 3 / 1e-4, 1);
  EXPECT_NEAR(m.metric[2](1, 1), 1.0 / 3 / 1e-4, 1);
  EXPECT_NEAR(m.metric[1](0, 0), 0.01, 1e-9);
}

TEST(RemeshSizing, NearestObstacleIsThatOfATestOfEachTriangle) {
  const SurfaceMesh m = surface_of(make_grid({1, 1}, {2, 2}, Diagonals::same));
  std::uint64_t random = 7;
  const auto point = [&](double size) {
    return Vec3<double>{size * next_random(random), size * next_random(random),
                        size * next_random(random)};
  };
  const double reach = 0.15;
  int found = 0, none = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Surroundings around;
    for (Index t = 0; t < 40; ++t) {
      const Vec3<double> middle = point(0.6);
      for (int j = 0; j < 3; ++j) around.positions.push_back(middle + point(0.1));
      around.triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
    }
    const Clearance clearance(m, around, reach);
    for (int n = 0; n < 100; ++n) {
      // The tree has what is within reach of the cloth's box, which is flat.
      const Vec3<double> x{next_random(random) / 2, next_random(random) / 2, 0};
      double nearest = reach;
      Vec3<double> there{};
      for (Index t = 0; t < 40; ++t) {
        const Vec3<double>* c = &around.positions[static_cast<std::size_t>(3 * t)];
        const Vec3<double> corners[4] = {x, c[0], c[1], c[2]};
        const Proximity<double> p = vertex_triangle(corners);
        if (p.distance_sq > nearest * nearest) continue;
        nearest = std::sqrt(p.distance_sq);
        there = x - p.difference;
      }
      const Clearance::Plane plane = clearance.nearest_obstacle(x, reach);
      for (Index guess = n % 5; guess < 40; guess += 5) {
        const Clearance::Plane guessed = clearance.nearest_obstacle(x, reach, guess);
        EXPECT_EQ(guessed.triangle, plane.triangle);
        EXPECT_EQ(length_sq(guessed.point - plane.point), 0);
        EXPECT_EQ(length_sq(guessed.normal - plane.normal), 0);
      }
      if (nearest == reach) {
        ++none;
        EXPECT_EQ(length_sq(plane.normal), 0);
        continue;
      }
      ++found;
      EXPECT_LT(length(plane.point - there), 1e-14);
      EXPECT_LT(length(plane.point + nearest * plane.normal - x), 1e-14);
    }
  }
  EXPECT_GT(found, 200);
  EXPECT_GT(none, 200);
}

// ---- operations

/// Whether everything in the mesh agrees with everything else.
void expect_consistent(const SurfaceMesh& m) {
  std::vector<double> mass(m.positions.size(), 0);
  for (Index h = 0; h < static_cast<Index>(m.twin.size()); ++h) {
    if (!m.alive(h / 3)) continue;
    const Index g = m.twin[static_cast<std::size_t>(h)];
    mass[static_cast<std::size_t>(m.from(h))] += m.triangle_mass(h / 3) / 3;
    const Index leaving = m.leaving[static_cast<std::size_t>(m.from(h))];
    ASSERT_GE(leaving, 0);
    ASSERT_TRUE(m.alive(leaving / 3));
    ASSERT_EQ(m.from(leaving), m.from(h));
    if (g < 0) continue;
    ASSERT_TRUE(m.alive(g / 3)) << "half-edge " << h;
    ASSERT_EQ(m.twin[static_cast<std::size_t>(g)], h);
    ASSERT_EQ(m.from(g), m.to(h));
    ASSERT_EQ(m.to(g), m.from(h));
  }
  for (std::size_t v = 0; v < mass.size(); ++v) {
    if (m.leaving[v] < 0) continue;
    EXPECT_NEAR(m.mass[v], mass[v], 1e-15);
  }
}

TEST(RemeshOperations, SplitKeepsMassMomentumAndPlace) {
  SurfaceMesh m = surface_of(make_grid({1, 1}, {3, 3}, Diagonals::alternating));
  for (std::size_t v = 0; v < m.positions.size(); ++v)
    m.velocities[v] = {double(v), std::sin(double(v)), 1};
  const Vec3<double> before = m.momentum();
  const double mass = m.total_mass();
  std::vector<Index> touched;
  for (const Index h : {0, 4, 11, 25}) split_edge(m, h, false, touched);
  expect_consistent(m);
  EXPECT_NEAR(m.total_mass(), mass, 1e-16);
  EXPECT_LT(length(m.momentum() - before), 1e-14);
}

TEST(RemeshOperations, SplitTakenBackLeavesNothing) {
  SurfaceMesh m = surface_of(make_grid({1, 1}, {3, 3}, Diagonals::alternating));
  const SurfaceMesh before = m;
  std::vector<Index> touched;
  for (Index h = 0; h < static_cast<Index>(before.twin.size()); ++h) {
    const Index v = split_edge(m, h, false, touched);
    undo_split(m, h, v, touched);
    expect_consistent(m);
    for (std::size_t t = 0; t < before.triangles.size(); ++t)
      for (int j = 0; j < 3; ++j) ASSERT_EQ(m.triangles[t].v[j], before.triangles[t].v[j]);
    for (std::size_t g = 0; g < before.twin.size(); ++g) ASSERT_EQ(m.twin[g], before.twin[g]);
  }
}

TEST(RemeshOperations, FlipTwiceIsTheSameEdge) {
  SurfaceMesh m = surface_of(make_grid({1, 1}, {2, 2}, Diagonals::same));
  for (Index h = 0; h < static_cast<Index>(m.twin.size()); ++h) {
    if (m.is_border(h)) continue;
    const Index a = m.from(h), c = m.apex(h);
    SurfaceMesh turned = m;
    flip_edge(turned, h);
    expect_consistent(turned);
    const std::vector<Index> star = turned.star(c);
    EXPECT_TRUE(std::any_of(star.begin(), star.end(), [&](Index g) {
      return turned.to(g) == m.apex(m.twin[static_cast<std::size_t>(h)]) ||
             turned.apex(g) == m.apex(m.twin[static_cast<std::size_t>(h)]);
    })) << a;
  }
}

/// Two triangles on an edge of length 2, their other corners `height` to either side of its middle.
SurfaceMesh rhombus(double height, const Mat2<double>& metric) {
  Mesh mesh;
  mesh.material = {{0, 0}, {2, 0}, {1, height}, {1, -height}};
  for (const Vec2<double>& u : mesh.material) mesh.positions.push_back({u[0], u[1], 0});
  mesh.triangles = {{{0, 1, 2}}, {{1, 0, 3}}};
  SurfaceMesh m = surface_of(mesh);
  m.metric.assign(4, metric);
  return m;
}

TEST(RemeshOperations, FlipsByTheAnisotropicDelaunayCriterion) {
  // Both wedges are 2 a, both products m a^2 - 1 in the metric diag(1, m): 4 a (m a^2 - 1) is to be
  // less than -4 a times the threshold.
  const auto flips = [](double a, double m, double threshold) {
    return should_flip(rhombus(a, diagonal(1, m)), 0, threshold);
  };
  EXPECT_FALSE(flips(1, 1, 0.01)) << "a square";
  EXPECT_TRUE(flips(0.9, 1, 0.01));
  EXPECT_FALSE(flips(0.996, 1, 0.01)) << "1 - 0.996^2 = 0.008";
  EXPECT_TRUE(flips(0.996, 1, 0.007));
  EXPECT_FALSE(flips(0.5, 4, 0.01)) << "a square in the metric";
  EXPECT_TRUE(flips(0.49, 4, 0.01)) << "4 0.49^2 = 0.96";
  EXPECT_FALSE(should_flip(rhombus(0.5, diagonal(1, 1)), 1, 0.01)) << "a border";
}

TEST(RemeshOperations, CornersOfTheOutlineStay) {
  const SurfaceMesh m = surface_of(make_grid({1, 1}, {4, 4}, Diagonals::alternating));
  int planned = 0;
  for (Index h = 0; h < static_cast<Index>(m.twin.size()); ++h) {
    CollapseResult plan;
    if (!plan_collapse(m, h, plan)) continue;
    ++planned;
    const Vec2<double> u = m.material[static_cast<std::size_t>(m.from(h))];
    EXPECT_FALSE(std::abs(u[0]) == 0.5 && std::abs(u[1]) == 0.5) << "a corner";
    if (std::abs(u[0]) == 0.5 || std::abs(u[1]) == 0.5) {
      EXPECT_TRUE(m.is_border(h));
    }
    SurfaceMesh less = m;
    collapse_edge(less, h, plan);
    expect_consistent(less);
  }
  EXPECT_GT(planned, 40);
}

TEST(RemeshOperations, MidpointIsHeldByPinsOfBothEnds) {
  PinSets sets;
  const Index a = sets.number({0, 2, 3}), b = sets.number({1, 2});
  EXPECT_EQ(sets.pins(sets.common(a, b)), std::vector<Index>{2});
  EXPECT_EQ(sets.common(a, 0), 0);
  EXPECT_EQ(sets.common(b, b), b);
}

// ---- scenes

std::size_t triangle_count(const Scene& scene) {
  std::size_t count = 0;
  for (const Cloth& cloth : scene.cloths) count += cloth.mesh.triangles.size();
  return count;
}

TEST(RemeshScene, FlatSheetBecomesCoarse) {
  Scene scene = scene_of({make_grid({1, 1}, {20, 20}, Diagonals::alternating)});
  scene.adaptive.remeshing.size_min = 0.05;
  scene.adaptive.remeshing.size_max = 0.5;
  const SceneRemesh done = remeshed(scene, state_at_start(scene));
  EXPECT_GT(done.counts.collapses, 300);
  EXPECT_LT(triangle_count(scene), 60u);
  EXPECT_NO_THROW(validate(scene));
}

/// [J] of the scene's only cloth
double stretching_of(const Scene& scene, const MaterialRows<double>& laws,
                     const std::vector<Vec3<double>>& positions) {
  const Mesh& mesh = scene.cloths[0].mesh;
  double sum = 0;
  for (const Tri& t : mesh.triangles) {
    Vec3<double> x[3];
    Vec2<double> u[3];
    for (int j = 0; j < 3; ++j) {
      x[j] = positions[static_cast<std::size_t>(t.v[j])];
      u[j] = mesh.material[static_cast<std::size_t>(t.v[j])];
    }
    const Vec2<double> a = u[1] - u[0], b = u[2] - u[0];
    const double det = a[0] * b[1] - a[1] * b[0];
    sum += stretching_energy(laws, 0, x, {{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}},
                             det / 2);
  }
  return sum;
}

TEST(RemeshScene, CostsNoMoreThanItsBudgetNearStrainLimits) {
  Scene scene = scene_of({make_grid({1, 1}, {20, 20}, Diagonals::alternating)});
  scene.adaptive.remeshing.size_min = 0.03;
  scene.adaptive.remeshing.size_max = 0.2;
  scene.materials[0].strain_limits = {0.95, 1.05};
  const MaterialRows<double> laws = material_rows<double>(scene.materials, {{}});
  InputState state = state_at_start(scene);
  // Flat: the budget includes bending.
  for (Vec3<double>& x : state.positions)
    x = {(1.03 + 0.02 * std::sin(9 * x[1])) * x[0], (1.02 + 0.03 * std::sin(7 * x[0])) * x[1], 0};
  const double before = stretching_of(scene, laws, state.positions);
  const double budget = 1e-3 * before;
  const SceneRemesh done = remesh_scene(scene, joined_inputs(scene, {}), named_inputs(scene),
                                        std::move(state), {}, {budget, &laws});
  EXPECT_GT(done.counts.flips + done.counts.collapses, 20);
  EXPECT_GT(done.counts.refused, 0);
  EXPECT_NEAR(stretching_of(done.scene, laws, done.state.positions), before, (1 + 1e-9) * budget);
}

TEST(RemeshScene, NothingToDoChangesNothing) {
  Scene scene = scene_of({make_grid({1, 1}, {20, 20}, Diagonals::alternating)});
  scene.adaptive.remeshing.size_min = 0.05;
  scene.adaptive.remeshing.size_max = 0.5;
  InputState state = remeshed(scene, state_at_start(scene)).state;
  const std::size_t count = triangle_count(scene);
  const SceneRemesh again = remeshed(scene, std::move(state));
  EXPECT_EQ(again.counts.splits, 0);
  EXPECT_GE(triangle_count(scene) + 4, count);
}

TEST(RemeshScene, VelocitiesOfAStepAgoGoWithTheirVerticesAndHaveMeansBetween) {
  Scene scene = scene_of({make_grid({1, 1}, {4, 4}, Diagonals::alternating)});
  scene.adaptive.remeshing.size_min = 0.05;
  scene.adaptive.remeshing.size_max = 0.1;
  InputState state = state_at_start(scene);
  for (const Vec3<double>& x : state.positions)
    state.previous_velocities.push_back({1 + x[0], 2 * x[1], x[0] - x[1]});
  const InputState done = remeshed(scene, std::move(state)).state;
  ASSERT_GT(done.positions.size(), 25u);
  ASSERT_EQ(done.positions.size(), done.previous_velocities.size());
  for (std::size_t v = 0; v < done.positions.size(); ++v) {
    const Vec3<double>& x = done.positions[v];
    EXPECT_LT(length(done.previous_velocities[v] - Vec3<double>{1 + x[0], 2 * x[1], x[0] - x[1]}),
              1e-14);
  }
}

TEST(RemeshScene, PinsKeepTheirVerticesAndGainMidpoints) {
  Scene scene = scene_of({make_grid({1, 1}, {4, 4}, Diagonals::alternating)});
  scene.adaptive.remeshing.size_min = 0.05;
  scene.adaptive.remeshing.size_max = 0.1;
  Pin pin;
  pin.vertices = {0, 1, 2, 3, 4};  // the lower edge
  scene.pins.push_back(pin);
  remeshed(scene, state_at_start(scene));
  EXPECT_NO_THROW(validate(scene));
  EXPECT_GE(scene.pins[0].vertices.size(), 11u);
  for (const Index v : scene.pins[0].vertices)
    EXPECT_EQ(scene.cloths[0].mesh.material[static_cast<std::size_t>(v)][1], -0.5);
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_NEAR(scene.cloths[0].mesh.material[k][0], -0.5 + 0.25 * double(k), 1e-15);
}

/// A fine sheet, held along its lower edge, that may become coarse.
Scene held_sheet(std::vector<Index> vertices) {
  Scene scene = scene_of({make_grid({1, 1}, {20, 20}, Diagonals::alternating)});
  scene.adaptive.remeshing.size_min = 0.05;
  scene.adaptive.remeshing.size_max = 0.5;
  Pin pin;
  pin.vertices = std::move(vertices);
  scene.pins.push_back(pin);
  return scene;
}

std::vector<Index> lower_edge() {
  std::vector<Index> vertices(21);
  std::iota(vertices.begin(), vertices.end(), 0);
  return vertices;
}

TEST(RemeshScene, AStraightPinnedEdgeBecomesCoarse) {
  Scene scene = held_sheet(lower_edge());
  remeshed(scene, state_at_start(scene));
  EXPECT_NO_THROW(validate(scene));
  const std::vector<Index>& held = scene.pins[0].vertices;
  EXPECT_GE(held.size(), 3u);
  EXPECT_LE(held.size(), 10u);
  double lo = 0, hi = 0;
  for (const Index v : held) {
    const Vec2<double>& u = scene.cloths[0].mesh.material[static_cast<std::size_t>(v)];
    EXPECT_EQ(u[1], -0.5);
    lo = std::min(lo, u[0]);
    hi = std::max(hi, u[0]);
  }
  EXPECT_EQ(lo, -0.5);
  EXPECT_EQ(hi, 0.5);
  // Nothing else on the edge: it is held from end to end.
  const auto on_edge =
      std::count_if(scene.cloths[0].mesh.material.begin(), scene.cloths[0].mesh.material.end(),
                    [](const Vec2<double>& u) { return u[1] == -0.5; });
  EXPECT_EQ(on_edge, std::ssize(held));
}

TEST(RemeshScene, PinnedVerticesStayWhereTheirEdgeIsNotAllThatNamesThem) {
  // Pleats at the start; a pin to a body; another pin in the middle of the edge; three vertices.
  Scene pleated = held_sheet(lower_edge());
  for (Vec3<double>& x : pleated.cloths[0].mesh.positions) x[2] = 0.01 * std::cos(20 * x[0]);
  InputState flat = state_at_start(held_sheet({}));
  remeshed(pleated, std::move(flat));
  EXPECT_EQ(pleated.pins[0].vertices.size(), 21u);

  Scene attached = held_sheet(lower_edge());
  attached.pins[0].obstacle = 0;
  remeshed(attached, state_at_start(attached));
  EXPECT_EQ(attached.pins[0].vertices.size(), 21u);

  Scene twice = held_sheet(lower_edge());
  Pin second;
  second.vertices = {10};
  twice.pins.push_back(second);
  remeshed(twice, state_at_start(twice));
  const auto& material = twice.cloths[0].mesh.material;
  EXPECT_NEAR(material[static_cast<std::size_t>(twice.pins[1].vertices[0])][0], 0, 1e-15);
  EXPECT_LT(twice.pins[0].vertices.size(), 21u);

  Scene three = held_sheet({8, 9, 10});
  remeshed(three, state_at_start(three));
  EXPECT_EQ(three.pins[0].vertices.size(), 3u);
}

TEST(RemeshScene, ASheetOverATipKeepsClear) {
  // A tent over a needle, which a coarser sheet would be cut by.
  Mesh mesh = make_grid({1, 1}, {20, 20}, Diagonals::alternating);
  Scene scene = scene_of({mesh});
  scene.adaptive.remeshing = {0.5, 0.5, infinity, infinity, infinity, 0.0};
  InputState state = state_at_start(scene);
  for (Vec3<double>& x : state.positions)
    x[2] = 0.3 * std::max(0.0, 1 - 2.5 * std::hypot(x[0], x[1]));
  Surroundings around;
  around.positions = {{-0.01, -0.01, -1}, {0.01, -0.01, -1}, {0, 0.01, -1}, {0, 0, 0.28}};
  around.triangles = {{{0, 1, 3}}, {{1, 2, 3}}, {{2, 0, 3}}, {{0, 2, 1}}};
  around.gap = 1e-4;
  const SceneRemesh done = remeshed(scene, std::move(state), around);
  EXPECT_GT(done.counts.refused, 0);
  Mesh cloth = scene.cloths[0].mesh;
  cloth.positions = done.state.positions;
  const Mesh needle{around.positions, {}, around.triangles};
  const lab::FrameVerdict verdict = lab::validate(cloth, &needle);
  EXPECT_TRUE(verdict.clean());
}

TEST(RemeshScene, MaterialBordersStay) {
  Scene scene = scene_of({make_grid({1, 1}, {16, 16}, Diagonals::alternating)});
  scene.materials.emplace_back();
  scene.materials[1].density = 0.7;
  scene.cloths[0].triangle_material.clear();
  for (const Tri& t : scene.cloths[0].mesh.triangles) {
    double x = 0;
    for (const Index v : t.v) x += scene.cloths[0].mesh.material[static_cast<std::size_t>(v)][0];
    scene.cloths[0].triangle_material.push_back(x > 0 ? 1 : 0);
  }
  scene.adaptive.remeshing.size_min = 0.05;
  scene.adaptive.remeshing.size_max = 0.4;
  remeshed(scene, state_at_start(scene));
  EXPECT_NO_THROW(validate(scene));
  const Mesh& mesh = scene.cloths[0].mesh;
  EXPECT_LT(mesh.triangles.size(), 150u);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const Index v : mesh.triangles[t].v) {
      const double x = mesh.material[static_cast<std::size_t>(v)][0];
      if (scene.cloths[0].triangle_material[t] == 1)
        EXPECT_GE(x, 0);
      else
        EXPECT_LE(x, 0);
    }
}

}  // namespace
}  // namespace weft::test
