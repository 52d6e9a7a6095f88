// The two levels: coarse meshes, what they hold, and the way back up.
#include "host/time_parallel/coarse_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <set>

#include "tests/unit/time_parallel/scenes.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

TEST(MaterialMap, LinearFunctionsComeBackExactly) {
  const Mesh coarse = make_grid({1, 0.6}, {5, 4}, Diagonals::alternating);
  const Mesh fine = make_grid({1, 0.6}, {23, 17}, Diagonals::alternating);
  const MaterialMap map = map_material(fine, coarse);
  const auto f = [](const Vec2<double>& u) { return 3 * u[0] - 2 * u[1] + 0.5; };
  std::vector<double> values;
  for (const auto& u : coarse.material) values.push_back(f(u));
  const std::vector<double> up = interpolated(map, values.data());
  ASSERT_EQ(up.size(), fine.positions.size());
  for (std::size_t v = 0; v < up.size(); ++v) {
    EXPECT_NEAR(up[v], f(fine.material[v]), 1e-12);
    EXPECT_NEAR(map.weight[v][0] + map.weight[v][1] + map.weight[v][2], 1, 1e-12);
    EXPECT_GE(*std::min_element(map.weight[v].begin(), map.weight[v].end()), 0);
  }
}

TEST(MaterialMap, VerticesOnVerticesHaveNoOtherPart) {
  const Mesh grid = make_grid({1, 1}, {6, 6}, Diagonals::same);
  const MaterialMap map = map_material(grid, grid);
  for (std::size_t v = 0; v < grid.positions.size(); ++v) {
    const auto k = static_cast<std::size_t>(
        std::max_element(map.weight[v].begin(), map.weight[v].end()) - map.weight[v].begin());
    EXPECT_EQ(map.corner[v][k], static_cast<Index>(v));
    EXPECT_EQ(map.weight[v][k], 1);
  }
}

TEST(MaterialMap, PlanesGoOnBeyondTheOutline) {
  const Mesh disc = make_disc(1, 12);
  const Mesh coarse = make_disc(1, 2);
  const MaterialMap map = map_material(disc, coarse);
  const auto up = interpolated(map, coarse.positions.data());
  for (std::size_t v = 0; v < up.size(); ++v)
    EXPECT_LT(length(up[v] - disc.positions[v]), 1e-12) << "a flat disc, vertex " << v;
}

TEST(MaterialMap, OverlappingPiecesAreToldByPlace) {
  // Two squares with the same material coordinates, one above the other.
  const auto pair_of = [](Index cells) {
    Mesh mesh = make_grid({1, 1}, {cells, cells}, Diagonals::same);
    const auto count = static_cast<Index>(mesh.positions.size());
    Mesh upper = mesh;
    for (auto& x : upper.positions) x[2] = 1;
    mesh.positions.insert(mesh.positions.end(), upper.positions.begin(), upper.positions.end());
    mesh.material.insert(mesh.material.end(), upper.material.begin(), upper.material.end());
    for (Tri t : upper.triangles) {
      for (Index& v : t.v) v += count;
      mesh.triangles.push_back(t);
    }
    return mesh;
  };
  const Mesh fine = pair_of(10);
  const Mesh coarse = pair_of(2);
  const auto up = interpolated(map_material(fine, coarse), coarse.positions.data());
  for (std::size_t v = 0; v < up.size(); ++v) EXPECT_LT(length(up[v] - fine.positions[v]), 1e-12);
}

TEST(CoarseScene, GridsGetADivisorOfTheirCells) {
  const Scene fine = hanging_sheet(20);
  const CoarseScene level = make_coarse_scene(fine);
  const Mesh& coarse = level.scene.cloths[0].mesh;
  EXPECT_EQ(coarse.triangles.size(), 2u * 4 * 4);
  EXPECT_EQ(level.scene.time.step, 0.02);
  EXPECT_EQ(level.scene.method, "implicit");
  // Every coarse vertex is a fine one, and a flat sheet comes back as it was.
  const auto up = upsampled(level, coarse.positions);
  for (std::size_t v = 0; v < up.size(); ++v)
    EXPECT_LT(length(up[v] - fine.cloths[0].mesh.positions[v]), 1e-12);
  // The two corners that are held.
  ASSERT_EQ(level.scene.pins.size(), 1u);
  EXPECT_EQ(level.scene.pins[0].vertices,
            (std::vector<Index>{grid_vertex(4, 0, 4), grid_vertex(4, 4, 4)}));
}

TEST(CoarseScene, SolvesAsItIsTold) {
  Scene fine = hanging_sheet(20);
  fine.solver.tolerance = 1e-4;
  fine.solver.newton_iterations = 7;
  const SolverSettings usual = make_coarse_scene(fine).scene.solver;
  EXPECT_EQ(usual.newton_iterations, 2);
  EXPECT_EQ(usual.newton_tolerance, 0.1);
  EXPECT_EQ(usual.tolerance, 0.01);
  fine.solver.tolerance = 0.03;
  fine.time_parallel.coarse_newton_iterations = 4;
  fine.time_parallel.coarse_newton_tolerance = 1e-3;
  fine.time_parallel.coarse_tolerance = 0.02;
  const SolverSettings told = make_coarse_scene(fine).scene.solver;
  EXPECT_EQ(told.newton_iterations, 4);
  EXPECT_EQ(told.newton_tolerance, 1e-3);
  EXPECT_EQ(told.tolerance, 0.03) << "no tighter than that of the slices";
}

TEST(CoarseScene, OtherMeshesAreRemeshed) {
  Scene fine = hanging_sheet(20);
  fine.cloths[0].mesh = make_disc(0.3, 20);
  fine.pins[0].vertices = {0};
  const CoarseScene level = make_coarse_scene(fine);
  const Mesh& coarse = level.scene.cloths[0].mesh;
  EXPECT_LT(4 * coarse.triangles.size(), fine.cloths[0].mesh.triangles.size());
  double area = 0;
  for (const Tri& t : coarse.triangles) {
    const auto p = [&](int k) { return coarse.positions[static_cast<std::size_t>(t.v[k])]; };
    area += length(cross(p(1) - p(0), p(2) - p(0))) / 2;
  }
  EXPECT_NEAR(area, 3.14159 * 0.09, 0.002) << "the outline stays";
  ASSERT_EQ(level.scene.pins[0].vertices.size(), 1u);
  EXPECT_LT(length(coarse.positions[static_cast<std::size_t>(level.scene.pins[0].vertices[0])]),
            1e-12);
}

TEST(CoarseScene, LinesOfPinsAndSpringsAreKept) {
  Scene fine = hanging_sheet(20);
  fine.pins[0].vertices.clear();
  for (Index i = 0; i <= 20; ++i) fine.pins[0].vertices.push_back(grid_vertex(20, i, 20));
  Handle handle;
  for (Index i = 0; i <= 20; ++i) handle.vertices.push_back(grid_vertex(20, i, 0));
  handle.stiffness = 10;
  fine.handles.push_back(handle);
  const CoarseScene level = make_coarse_scene(fine);
  EXPECT_EQ(level.scene.pins[0].vertices.size(), 5u);
  EXPECT_EQ(level.scene.handles[0].vertices.size(), 5u);
  EXPECT_DOUBLE_EQ(level.scene.handles[0].stiffness * 5, 10.0 * 21);
}

TEST(CoarseScene, RefusesWhatDoesNotGetCoarser) {
  const Scene fine = hanging_sheet(1);
  try {
    make_coarse_scene(fine);
    FAIL() << "a sheet of two triangles";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("cloths[0] (sheet): 2 triangles"), std::string::npos)
        << error.what();
  }
}

TEST(CoarseScene, HatFunctionsAreAPartitionOfTheArea) {
  const Scene fine = hanging_sheet(20);
  const CoarseScene level = make_coarse_scene(fine);
  const Tracking tracking = make_tracking(fine, level);
  ASSERT_EQ(tracking.offset.size(), 25u + 1);
  EXPECT_NEAR(std::accumulate(tracking.weight.begin(), tracking.weight.end(), 0.0), 0.36, 1e-12);
  EXPECT_EQ(std::count(tracking.free_from.begin(), tracking.free_from.end(), 0.0), 23);
}

}  // namespace
}  // namespace weft::test
