// Slices that remesh: states on other meshes, starts on meshes of their own, and the same bits
// whoever works them off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/simulation/remeshing.hpp"
#include "host/time_parallel/boundary_states.hpp"
#include "host/time_parallel/coarse_run.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/material_frame.hpp"
#include "host/time_parallel/slice_boundary.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "host/time_parallel/slices.hpp"
#include "tests/unit/time_parallel/memory_sink.hpp"
#include "tests/unit/time_parallel/scenes.hpp"
#include "tests/unit/time_parallel/slices_fixture.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

namespace fs = std::filesystem;

/// The unit square in two triangles, and in four around its centre.
struct Squares {
  Mesh two, four;

  Squares() {
    two.material = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    two.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    two.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
    four = two;
    four.material.push_back({0.75, 0.25});
    four.positions.push_back({0.75, 0.25, 0});
    four.triangles = {{{0, 1, 4}}, {{1, 2, 4}}, {{2, 3, 4}}, {{3, 0, 4}}};
  }
};

TEST(MaterialFrame, ValuesAreLinearOverTheTrianglesTheyComeFrom) {
  const Squares squares;
  Frame frame;
  frame.cloth_positions = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 2}, {0, 1, 0}}};
  frame.cloth_velocities = {{{0, 0, 0}, {8, 0, 0}, {4, 0, 0}, {0, 0, 0}}};
  const Frame finer = frame_on(frame, {&squares.two}, {&squares.four});
  // (0.75, 0.25) is 1/4 of the first corner, 1/2 of the second, and 1/4 of the third.
  ASSERT_EQ(finer.cloth_positions[0].size(), 5u);
  EXPECT_NEAR(finer.cloth_positions[0][4][2], 0.5, 1e-15);
  EXPECT_NEAR(finer.cloth_velocities[0][4][0], 5, 1e-14);
  EXPECT_EQ(finer.cloth_positions[0][2][2], 2);
  // What is between the corners of the coarser mesh is not seen by it.
  const Frame back = frame_on(finer, {&squares.four}, {&squares.two});
  ASSERT_EQ(back.cloth_positions[0].size(), 4u);
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_EQ(length(back.cloth_positions[0][v] - frame.cloth_positions[0][v]), 0);
}

TEST(MaterialFrame, MeshesAreToldByTrianglesAndMaterial) {
  const Squares squares;
  Mesh moved = squares.two;
  moved.positions[0][2] = 3;
  EXPECT_TRUE(same_meshes({&squares.two}, {&moved})) << "where it is says nothing";
  EXPECT_FALSE(same_meshes({&squares.two}, {&squares.four}));
  Mesh turned = squares.two;
  turned.triangles = {{{0, 1, 3}}, {{1, 2, 3}}};
  EXPECT_FALSE(same_meshes({&squares.two}, {&turned}));
  Mesh other = squares.two;
  other.material[1][0] = 2;
  EXPECT_FALSE(same_meshes({&squares.two}, {&other}));
}

/// The hanging sheet on two triangles a side, of which slices make edges of 3 cm and more.
Scene adaptive_sheet(Precision precision = Precision::double_precision) {
  Scene scene = hanging_sheet(4, precision);
  scene.time_parallel.method = "adaptive";
  scene.time_parallel.coarsening = 3;
  Remeshing sizes;
  sizes.size_min = 0.04;
  sizes.size_max = 0.3;
  scene.cloths[0].remeshing = sizes;
  return scene;
}

double longest_edge(const Mesh& mesh) {
  double longest = 0;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      longest =
          std::max(longest, length(mesh.material[static_cast<std::size_t>(t.v[k])] -
                                   mesh.material[static_cast<std::size_t>(t.v[(k + 1) % 3])]));
  return longest;
}

double material_area(const Mesh& mesh) {
  double area = 0;
  for (const Tri& t : mesh.triangles) {
    const auto u = [&](int k) { return mesh.material[static_cast<std::size_t>(t.v[k])]; };
    const Vec2<double> a = u(1) - u(0), b = u(2) - u(0);
    area += std::abs(a[0] * b[1] - a[1] * b[0]) / 2;
  }
  return area;
}

TEST(AdaptiveCoarseScene, EdgesAreThoseOfTheSlicesTimesTheRatio) {
  const Scene fine = adaptive_sheet();
  const CoarseScene level = make_coarse_scene(fine);
  const Mesh& coarse = level.scene.cloths[0].mesh;
  EXPECT_EQ(level.scene.method, "implicit");
  EXPECT_NEAR(material_area(coarse), 0.36, 1e-12);
  // The scene's own mesh has edges of 0.15 m and more.
  EXPECT_GT(coarse.triangles.size(), fine.cloths[0].mesh.triangles.size());
  EXPECT_LT(longest_edge(coarse), 3 * 0.04 * 1.5);
  ASSERT_EQ(level.scene.pins.size(), 1u);
  std::set<double> held;
  for (const Index v : level.scene.pins[0].vertices) {
    EXPECT_EQ(coarse.material[static_cast<std::size_t>(v)][1],
              fine.cloths[0].mesh.material.back()[1]);
    held.insert(coarse.material[static_cast<std::size_t>(v)][0]);
  }
  const auto& corners = fine.cloths[0].mesh.material;
  EXPECT_EQ(held, (std::set<double>{corners.front()[0], corners.back()[0]}));
}

TEST(AdaptiveCoarseScene, OneThatRemeshesHasSizesOfItsOwn) {
  Scene fine = adaptive_sheet();
  fine.time_parallel.coarse_adaptive = true;
  const CoarseScene level = make_coarse_scene(fine);
  EXPECT_EQ(level.scene.method, "adaptive");
  ASSERT_TRUE(level.scene.cloths[0].remeshing);
  EXPECT_DOUBLE_EQ(level.scene.cloths[0].remeshing->size_min, 3 * 0.04);
  EXPECT_DOUBLE_EQ(level.scene.cloths[0].remeshing->size_max, 0.3);
  EXPECT_EQ(level.scene.cloths[0].remeshing->refine_angle, fine.cloths[0].remeshing->refine_angle);
}

TEST(AdaptiveCoarseScene, RefusesMillionsOfTriangles) {
  Scene fine = adaptive_sheet();
  fine.cloths[0].remeshing->size_min = 1e-5;
  try {
    make_coarse_scene(fine);
    FAIL() << "edges of a hundredth of a millimetre";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("remeshing.size[0]"), std::string::npos)
        << error.what();
  }
}

TEST(AdaptiveCoarseScene, EvenSizesKeepAMeshAsFineAsItIs) {
  const Mesh grid = hanging_sheet(8).cloths[0].mesh;
  const Remeshing sizes = even_sizes(grid, 1);
  EXPECT_EQ(sizes.size_min, sizes.size_max);
  EXPECT_EQ(even_sizes(grid, 3).size_min, 3 * sizes.size_min);
  // Squares of 0.075 m; collapses end somewhat before edges are that short.
  EXPECT_GT(sizes.size_min, 0.075);
  EXPECT_LT(sizes.size_min, 2 * 0.075);
}

class AdaptiveSlices : public SlicesFixture {
 protected:
  /// Coarse states up to a step, in a directory of their own.
  fs::path coarse_states(const CoarseScene& level, std::int64_t steps) const {
    const fs::path directory = directory_ / "coarse_states";
    fs::create_directories(directory);
    CoarseRun run(level, directory);
    const auto never = [] { return false; };
    while (run.simulation().step_number() < steps) EXPECT_TRUE(run.step(never, [](double) {}).done);
    return directory;
  }
  /// The same bits from one worker and several, given the partition, and cut off half-way.
  void expect_same_bits(const TimeParallelScene& scene, const std::vector<int>& workers);
  /// A slice that starts after a few coarse steps: on a mesh of its own, clean, with the coarse
  /// run's averages, and taken by the method.
  void expect_start(Scene sheet);
  static void expect_averages(const CoarseScene& level, const fs::path& coarse,
                              const Simulation& slice);
};

void AdaptiveSlices::expect_same_bits(const TimeParallelScene& scene,
                                      const std::vector<int>& workers) {
  const int slices = scene.slices();
  MemorySink sink;
  const SlicesOutcome whole = run_slices(scene, options("whole", 1), sink);
  ASSERT_TRUE(whole.done);
  EXPECT_EQ(sink.steps_taken, scene.steps());
  const std::string first = states("whole", slices);
  for (const int count : workers) {
    const std::string name = std::to_string(count);
    MemorySink other;
    const SlicesOutcome outcome = run_slices(scene, options(name, count), other);
    ASSERT_TRUE(outcome.done);
    EXPECT_EQ(outcome.starts, whole.starts) << "Algorithm 1 on counted work, " << count;
    EXPECT_TRUE(states(name, slices) == first) << count;
  }
  SliceOptions given = options("given", 2);
  given.starts = whole.starts;
  MemorySink other;
  EXPECT_TRUE(run_slices(scene, given, other).done);
  EXPECT_TRUE(states("given", slices) == first);
  MemorySink cut, rest;
  SliceOptions stopped = options("cut", 2);
  stopped.stop = [&] { return cut.steps_taken > scene.steps() / 2; };
  EXPECT_FALSE(run_slices(scene, stopped, cut).done);
  EXPECT_TRUE(run_slices(scene, options("cut", 2), rest).done);
  EXPECT_EQ(cut.steps_taken + rest.steps_taken, scene.steps()) << "nothing twice";
  EXPECT_TRUE(states("cut", slices) == first);
}

void AdaptiveSlices::expect_start(Scene sheet) {
  sheet.obstacles.clear();  // contact comes before averages
  const TimeParallelScene scene(sheet, 2);
  constexpr std::int64_t coarse_steps = 8, step = 30;  // between two coarse ones
  const fs::path coarse = coarse_states(scene.coarse(), coarse_steps);
  const fs::path file = directory_ / "start.weft";
  const SliceStart start = write_slice_start(scene.fine(), scene.coarse(), step, coarse, file,
                                             [](double) { return true; });
  EXPECT_EQ(start.refused, "");
  EXPECT_GT(start.iterations, 0) << start.note;
  Simulation slice(scene.fine(), host_devices(1));
  const std::size_t own = slice.scene().cloths[0].mesh.triangles.size();
  slice.resume(file, weft::SceneChanges::allow);
  const Mesh& mesh = slice.scene().cloths[0].mesh;
  EXPECT_EQ(slice.step_number(), step);
  EXPECT_NE(mesh.triangles.size(), own);
  EXPECT_NEAR(material_area(mesh), 0.36, 1e-12);
  EXPECT_TRUE(free_of_intersections(slice.scene(), slice.frame()));
  expect_averages(scene.coarse(), coarse, slice);
  while (slice.step_number() < scene.steps()) ASSERT_EQ(slice.step().failure, Failure::none);
}

/// Sums of positions by area and coarse hat functions, but for what is held.
void AdaptiveSlices::expect_averages(const CoarseScene& level, const fs::path& coarse,
                                     const Simulation& slice) {
  CoarseStates states(level, coarse, slice.scene());
  const double time = static_cast<double>(slice.step_number()) * slice.scene().time.step;
  const Tracking sums = make_tracking(slice.scene(), states.level_at(time));
  const std::vector<Vec3<double>> wanted = states.fine_state(time).positions;
  const std::vector<Vec3<double>> there = slice.frame().cloth_positions[0];
  ASSERT_EQ(wanted.size(), there.size());
  double off = 0;
  for (std::size_t row = 0; row + 1 < sums.offset.size(); ++row) {
    if (sums.free_from[row] != 0) continue;
    Vec3<double> miss{};
    double weight = 0;
    for (Offset k = sums.offset[row]; k < sums.offset[row + 1]; ++k) {
      const auto v = static_cast<std::size_t>(sums.input[static_cast<std::size_t>(k)]);
      miss += sums.weight[static_cast<std::size_t>(k)] * (there[v] - wanted[v]);
      weight += sums.weight[static_cast<std::size_t>(k)];
    }
    off = std::max(off, length(miss) / weight);
  }
  EXPECT_LT(off, 1e-9);
  // And detail is there: the coarse surface has none.
  double detail = 0;
  for (std::size_t v = 0; v < there.size(); ++v)
    detail = std::max(detail, length(there[v] - wanted[v]));
  EXPECT_GT(detail, 1e-4);
}

TEST_F(AdaptiveSlices, StartsHaveMeshesOfTheirOwn) {
  expect_start(adaptive_sheet());
}

TEST_F(AdaptiveSlices, StartsAreMadeOfCoarseMeshesThatChange) {
  Scene sheet = adaptive_sheet();
  sheet.time_parallel.coarse_adaptive = true;
  expect_start(sheet);
}

TEST_F(AdaptiveSlices, OneSliceIsTheAdaptiveRun) {
  const TimeParallelScene scene(adaptive_sheet(), 1);
  MemorySink sink;
  ASSERT_TRUE(run_slices(scene, options("one", 1), sink).done);
  Simulation serial(scene.fine(), host_devices(1));
  while (serial.step_number() < scene.steps()) ASSERT_EQ(serial.step().failure, Failure::none);
  serial.save(directory_ / "serial.weft");
  EXPECT_TRUE(bytes(directory_ / "serial.weft") == bytes(SliceFiles(directory_ / "one", 0).end()));
}

// A seam is looked at on the mesh that the slice after it starts with; it jumps as far as with
// meshes that stay: what the coarse run goes another way.
TEST_F(AdaptiveSlices, SeamsAreOfOneMesh) {
  Scene sheet = adaptive_sheet();
  sheet.obstacles.clear();
  Scene fixed = sheet;
  fixed.time_parallel.method = "implicit";
  fixed.cloths[0].mesh = make_grid({0.6, 0.6}, {15, 15}, Diagonals::alternating);  // 4 cm
  fixed.pins[0].vertices = {grid_vertex(15, 0, 15), grid_vertex(15, 15, 15)};
  BoundaryJump jump[2];
  for (const bool adapts : {true, false}) {
    const TimeParallelScene scene(adapts ? sheet : fixed, 2);
    SliceOptions o = options(adapts ? "adaptive" : "fixed", 2);
    o.starts = {0, 32};
    MemorySink sink;
    const SlicesOutcome outcome = run_slices(scene, o, sink);
    ASSERT_TRUE(outcome.done);
    ASSERT_EQ(outcome.seams.size(), 1u);
    jump[adapts ? 0 : 1] = outcome.seams[0];
    BoundaryStates states(scene.fine(), o.run);
    EXPECT_TRUE(states.free_before(1));
    const BoundarySides sides = states.at(1);
    const std::size_t count = sides.scene.cloths[0].mesh.positions.size();
    EXPECT_EQ(sides.before.cloth_positions[0].size(), count);
    EXPECT_EQ(sides.after.cloth_positions[0].size(), count);
    EXPECT_TRUE(free_of_intersections(sides.scene, sides.after));
    EXPECT_EQ(boundary_jump(sides.scene, sides.before, sides.after).position,
              outcome.seams[0].position);
  }
  EXPECT_GT(jump[0].position_rms, 0);
  EXPECT_LT(jump[0].position_rms, 1.5 * jump[1].position_rms);
  EXPECT_LT(jump[0].velocity, 1.5 * jump[1].velocity);
}

TEST_F(AdaptiveSlices, SameBitsForAnyNumberOfWorkers) {
  expect_same_bits(TimeParallelScene(adaptive_sheet(Precision::single_precision), 3), {2, 5});
}

TEST_F(AdaptiveSlices, SameBitsWhereTheCoarseRunRemeshesToo) {
  Scene sheet = adaptive_sheet(Precision::single_precision);
  sheet.time_parallel.coarse_adaptive = true;
  expect_same_bits(TimeParallelScene(sheet, 3), {2});
}

TEST_F(AdaptiveSlices, SameBitsWhereTheCoarseRunAloneRemeshes) {
  Scene sheet = hanging_sheet(20, Precision::single_precision);
  sheet.time_parallel.coarse_adaptive = true;
  expect_same_bits(TimeParallelScene(sheet, 3), {2});
}

TEST_F(AdaptiveSlices, SameBitsWhereACameraLooksOn) {
  Scene sheet = adaptive_sheet(Precision::single_precision);
  sheet.time_parallel.method = "view";
  CameraKey key;
  key.position = {0, -1.5, 0.2};
  key.look_at = {0, 0, -0.1};
  sheet.camera.keys = {key};
  expect_same_bits(TimeParallelScene(sheet, 3), {2});
}

}  // namespace
}  // namespace weft::test
