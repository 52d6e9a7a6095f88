// Untangling of whole scenes: vertices that move, vertices that stay, and messages of failures.
#include "host/untangle/untangle_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/intersection_check.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/scene/tangled_start.hpp"
#include "tests/unit/untangle/tangles.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

using testing::HasSubstr;

Scene scene_of(std::vector<Mesh> cloths) {
  Scene scene;
  scene.file = "made.json";
  scene.materials.push_back({});
  for (Mesh& mesh : cloths) {
    Cloth cloth;
    cloth.name = "sheet" + std::to_string(scene.cloths.size());
    cloth.mesh = std::move(mesh);
    scene.cloths.push_back(std::move(cloth));
  }
  scene.contact.untangle = true;
  return scene;
}

void add_ball(Scene& scene, double radius, const Point& centre) {
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(radius, 2);
  ball.transform.translate = centre;
  scene.obstacles.push_back(std::move(ball));
}

std::vector<Point> positions(const Scene& scene) {
  std::vector<Point> all;
  for (const Cloth& cloth : scene.cloths)
    all.insert(all.end(), cloth.mesh.positions.begin(), cloth.mesh.positions.end());
  return all;
}

std::string refusal(Scene scene) {
  try {
    untangle_start(scene, {});
  } catch (const SceneError& e) {
    return e.what();
  }
  return {};
}

TEST(UntangleScene, PartsClothsAndPassesTheCheck) {
  Scene scene = scene_of({flat_grid(16, 1, {0, 0, 0}), tilted_grid(16, 0.5, {0, 0, 0})});
  add_ball(scene, 0.2, {0.2, 0.1, -0.1});
  EXPECT_THROW(refuse_intersecting_start(scene), SceneError);
  untangle_start(scene, {});
  EXPECT_NO_THROW(refuse_intersecting_start(scene));
}

TEST(UntangleScene, LeavesOthersAloneToTheBit) {
  Scene scene = scene_of({flat_grid(16, 1, {0, 0, 0}), flat_grid(16, 1, {0.1, 0, 0.01})});
  add_ball(scene, 0.2, {0, 0, -0.25});
  const std::vector<Point> before = positions(scene);
  untangle_start(scene, {});
  EXPECT_TRUE(positions(scene) == before);
}

TEST(UntangleScene, PinnedVerticesStay) {
  Scene scene = scene_of({flat_grid(16, 1, {0, 0, 0.1})});
  add_ball(scene, 0.25, {0.01, 0.02, 0});
  Pin pin;
  for (Index v = 0; v < 17; ++v) pin.vertices.push_back(v);
  scene.pins.push_back(pin);
  const std::vector<Point> before = positions(scene);
  untangle_start(scene, {});
  const std::vector<Point> after = positions(scene);
  for (const Index v : pin.vertices)
    EXPECT_TRUE(after[static_cast<std::size_t>(v)] == before[static_cast<std::size_t>(v)]);
  EXPECT_FALSE(after == before);
  EXPECT_NO_THROW(refuse_intersecting_start(scene));
}

TEST(UntangleScene, HeavyClothMovesLess) {
  Scene scene = scene_of({flat_grid(16, 1, {0, 0, 0}), tilted_grid(16, 0.3, {0.3, 0, 0})});
  scene.materials.push_back({});
  scene.materials[1].density = 100 * scene.materials[0].density;
  scene.cloths[1].material = 1;
  const Scene before = scene;
  untangle_start(scene, {});
  double way[2] = {0, 0};
  for (std::size_t c = 0; c < 2; ++c)
    for (std::size_t v = 0; v < scene.cloths[c].mesh.positions.size(); ++v)
      way[c] += length(scene.cloths[c].mesh.positions[v] - before.cloths[c].mesh.positions[v]);
  EXPECT_GT(way[1], 0);
  EXPECT_GT(way[0], 5 * way[1]);
}

TEST(UntangleScene, WeldedVerticesGoTogether) {
  // Two halves of a sheet, sewn along x = 0, with a ball through the seam.
  const Mesh right = moved(make_grid({0.5, 1}, {8, 16}, Diagonals::alternating), {0.25, 0, 0.1});
  Mesh left = right;
  for (Point& x : left.positions) x[0] -= 0.5;
  Scene scene = scene_of({left, right});
  add_ball(scene, 0.2, {0.01, 0.02, 0});
  Seam seam;
  seam.cloths[1] = 1;
  seam.weld_distance = 1e-3;
  for (Index row = 0; row <= 16; ++row) {
    seam.vertices[0].push_back(9 * row + 8);
    seam.vertices[1].push_back(9 * row);
  }
  scene.seams.push_back(seam);
  const Sewing sewing = sewing_at_start(scene);
  ASSERT_TRUE(sewing.complete());
  untangle_start(scene, sewing.welded);
  EXPECT_NO_THROW(refuse_intersecting_start(scene, sewing.welded));
  for (std::size_t k = 0; k < seam.vertices[0].size(); ++k)
    EXPECT_TRUE(scene.cloths[0].mesh.positions[static_cast<std::size_t>(seam.vertices[0][k])] ==
                scene.cloths[1].mesh.positions[static_cast<std::size_t>(seam.vertices[1][k])]);
}

TEST(UntangleScene, WithoutSelfContactOnlyObstaclesCount) {
  Scene scene = scene_of({flat_grid(16, 1, {0, 0, 0}), tilted_grid(16, 0.5, {0, 0, 0})});
  scene.contact.self = false;
  const std::vector<Point> before = positions(scene);
  untangle_start(scene, {});
  EXPECT_TRUE(positions(scene) == before);
}

TEST(UntangleScene, SaysWhatCannotBeParted) {
  Scene scene = scene_of({flat_grid(12, 1, {0.003, 0.001, 0.1})});
  add_ball(scene, 0.3, {0, 0, 0});
  Pin pin;
  pin.vertices = {6 * 13 + 6};  // in the ball
  scene.pins.push_back(pin);
  const std::string said = refusal(scene);
  EXPECT_THAT(said, HasSubstr("made.json: cloths[0] (sheet0): triangles "));
  EXPECT_THAT(said, HasSubstr(" of ball intersect, "));
  EXPECT_THAT(said, HasSubstr("after untangling, which leaves "));
  EXPECT_THAT(said, HasSubstr(" m between sheet0 and ball at ("));
  EXPECT_THAT(said, HasSubstr("); allowed: a start free of"));
}

/// A ring through a sheet, linked like a chain, with pins that leave no way around the border.
TEST(UntangleScene, NamesTheContoursOfAChainAndTheirPlaces) {
  Mesh ring = make_tube(0.2, 0.1, {36, 3});
  for (Point& x : ring.positions) x = {x[0] + 0.01, x[2] + 0.004, x[1] + 0.03};
  Scene scene = scene_of({flat_grid(16, 1, {0, 0, 0}), ring});
  scene.origin = Point{10, 20, 30};
  for (std::size_t c = 0; c < 2; ++c) {
    Pin pin;
    pin.cloth = static_cast<Index>(c);
    const std::vector<Point>& x = scene.cloths[c].mesh.positions;
    for (std::size_t v = 0; v < x.size(); ++v)
      if (c == 0 ? std::max(std::fabs(x[v][0]), std::fabs(x[v][1])) > 0.49
                 : std::fabs(x[v][2] - 0.03) > 0.19)
        pin.vertices.push_back(static_cast<Index>(v));
    scene.pins.push_back(pin);
  }
  try {
    untangle_start(scene, {});
    FAIL() << "it was parted";
  } catch (const TangledStart& tangled) {
    const std::string said = tangled.what();
    const std::string before = " m between sheet0 and sheet1 at (";
    const std::size_t found = said.find(before);
    ASSERT_NE(found, std::string::npos) << said;
    double place[3];
    ASSERT_EQ(std::sscanf(said.c_str() + found + before.size(), "%lg, %lg, %lg", &place[0],
                          &place[1], &place[2]),
              3);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(place[k], tangled.place()[k] + (*scene.origin)[k], 0.051) << "three digits";
    EXPECT_TRUE(tangled.left().cloth_positions ==
                std::vector<std::vector<Point>>(
                    {scene.cloths[0].mesh.positions, scene.cloths[1].mesh.positions}));
    EXPECT_LT(length(tangled.place()), 0.8) << "near the sheet";
  }
}

TEST(UntangleScene, ClothWhollyInsideIsStillRefused) {
  Scene scene = scene_of({flat_grid(6, 0.1, {0.003, 0.001, 0})});
  add_ball(scene, 0.3, {0, 0, 0});
  EXPECT_EQ(refusal(scene), "") << "nothing intersects";
  EXPECT_THROW(refuse_intersecting_start(scene), SceneError);
}

TEST(UntangleScene, SimulationStartsFromTheResult) {
  Scene scene = scene_of({flat_grid(12, 1, {0, 0, 0}), tilted_grid(12, 0.4, {0, 0, 0})});
  scene.precision = Precision::double_precision;
  scene.cloths[0].velocity = {0, 0, 1};
  Scene untangled = scene;
  untangle_start(untangled, {});
  const Frame frame = Simulation(scene, host_devices(1)).frame();
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_TRUE(frame.cloth_positions[c] == untangled.cloths[c].mesh.positions);
    for (const Point& v : frame.cloth_velocities[c])
      EXPECT_TRUE(v == (Point{0, 0, c == 0 ? 1.0 : 0.0}));
  }
  scene.contact.untangle = false;
  EXPECT_THROW(Simulation(scene, host_devices(1)), SceneError);
}

}  // namespace
}  // namespace weft::test
