// Seams that close, and what a simulation says of those that do not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "host/scene/intersection_check.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

Scene bare_scene() {
  Scene s;
  s.precision = Precision::double_precision;
  s.materials.push_back(test::cotton());
  s.time.step = 0.005;
  s.time.frame_rate = 50;
  s.gravity = {0, 0, 0};
  return s;
}

/// A flat panel whose lower left corner is `corner`, with sides along the vectors `u` and `v`.
Cloth panel(int columns, int rows, const Vec3<double>& corner, const Vec3<double>& u,
            const Vec3<double>& v) {
  Cloth cloth;
  const int across = columns + 1;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double x = static_cast<double>(i) / columns;
      const double y = static_cast<double>(j) / rows;
      cloth.mesh.positions.push_back(corner + x * u + y * v);
      cloth.mesh.material.push_back({x * length(u), y * length(v)});
    }
  for (Index j = 0; j < rows; ++j)
    for (Index i = 0; i < columns; ++i) {
      const Index a = j * across + i;
      cloth.mesh.triangles.push_back({{a, a + 1, a + across + 1}});
      cloth.mesh.triangles.push_back({{a, a + across + 1, a + across}});
    }
  return cloth;
}

/// Vertex numbers of a column of such a panel, from its lower end.
std::vector<Index> column(int columns, int rows, int i) {
  std::vector<Index> vertices;
  for (Index j = 0; j <= rows; ++j) vertices.push_back(j * (columns + 1) + i);
  return vertices;
}

Seam seam_of(Index a, const std::vector<Index>& of_a, Index b, const std::vector<Index>& of_b,
             double weld_distance) {
  Seam seam;
  seam.cloths[0] = a;
  seam.cloths[1] = b;
  seam.vertices[0] = of_a;
  seam.vertices[1] = of_b;
  seam.stiffness = 200;
  seam.ramp_time = 0.1;
  seam.weld_distance = weld_distance;
  return seam;
}

/// Two panels side by side, and a seam that draws them together.
Scene side_by_side(double gap) {
  Scene s = bare_scene();
  s.cloths.push_back(panel(3, 3, {-0.3 - gap, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}));
  s.cloths.push_back(panel(3, 3, {0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}));
  s.cloths[0].name = "left";
  s.cloths[1].name = "right";
  s.seams.push_back(seam_of(0, column(3, 3, 3), 1, column(3, 3, 0), 2e-3));
  return s;
}

/// Steps until no seam is open.
void sew(Simulation& simulation, int frames_max) {
  const auto open = [&] {
    const auto seams = simulation.seams();
    return std::any_of(seams.begin(), seams.end(), [](const SeamState& s) { return s.open > 0; });
  };
  while (open() && simulation.frame_number() < frames_max) {
    const StepReport report = simulation.step();
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
  }
  ASSERT_FALSE(open());
}

/// Refuses a frame that intersects.
void expect_clear(const Simulation& simulation) {
  Scene s = simulation.scene();
  const Frame frame = simulation.frame();
  for (std::size_t c = 0; c < s.cloths.size(); ++c)
    s.cloths[c].mesh.positions = frame.cloth_positions[c];
  for (std::size_t o = 0; o < s.obstacles.size(); ++o) {
    s.obstacles[o].mesh.positions = frame.obstacle_positions[o];
    s.obstacles[o].transform = {};
    s.obstacles[o].motion.clear();
  }
  std::vector<unsigned char> welded;
  for (const Seam& seam : s.seams)
    for (std::size_t k = 0; k < seam.vertices[0].size(); ++k)
      welded.push_back(frame.cloth_positions[at(seam.cloths[0])][at(seam.vertices[0][k])] ==
                       frame.cloth_positions[at(seam.cloths[1])][at(seam.vertices[1][k])]);
  EXPECT_NO_THROW(refuse_intersecting_start(s, welded));
}

/// A pair that is close enough soon, among ten.
TEST(Seams, StragglersAreWeldedInEveryFifthFrameAndInTheLast) {
  for (const int frames : {50, 3}) {
    Scene s = side_by_side(2.1e-3);
    const int rows = 8;
    s.cloths[0].mesh = panel(3, rows, {-0.3 - 2.1e-3, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}).mesh;
    s.cloths[1].mesh = panel(3, rows, {0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}).mesh;
    s.seams = {seam_of(0, {column(3, rows, 3)[4]}, 1, {column(3, rows, 0)[4]}, 2e-3),
               seam_of(0, column(3, rows, 0), 1, column(3, rows, 3), 2e-3)};
    s.seams[1].start_time = 100;
    s.time.frames = frames;
    Simulation simulation(s, host_devices(1));
    for (int step = 0; step < 40 && simulation.seams().front().open > 0; ++step)
      ASSERT_EQ(simulation.step().failure, Failure::none);
    EXPECT_EQ(simulation.frame_number(), std::min(frames, 5));
    EXPECT_EQ(simulation.seams().front().open, 0);
    EXPECT_EQ(simulation.seams().back().open, rows + 1);
  }
}

TEST(SeamState, SayWhatIsOpenAndWhenItClosed) {
  Scene s = side_by_side(0.03);
  s.seams.push_back(seam_of(0, {1}, 0, {13}, 2e-3));  // two corners that never meet
  s.seams[1].stiffness = 1e-6;
  s.seams[1].may_stay_open = true;
  Simulation simulation(s, host_devices(1));
  SeamState seam = simulation.seams()[0];
  EXPECT_EQ("left", seam.cloths[0]);
  EXPECT_EQ("right", seam.cloths[1]);
  EXPECT_EQ(4, seam.pairs);
  EXPECT_EQ(4, seam.open);
  EXPECT_NEAR(0.03, seam.largest_gap, 1e-12);
  EXPECT_FALSE(seam.closed_at);
  EXPECT_FALSE(seam.due) << "its springs have just begun to pull";

  while (simulation.seams()[0].open > 0 && simulation.frame_number() < 100)
    ASSERT_EQ(Failure::none, simulation.step().failure);
  seam = simulation.seams()[0];
  EXPECT_EQ(0, seam.open);
  EXPECT_EQ(0, seam.largest_gap);
  ASSERT_TRUE(seam.closed_at);
  EXPECT_EQ(simulation.time(), *seam.closed_at);
  while (simulation.time() < 0.11) simulation.step();
  EXPECT_EQ(seam.closed_at, simulation.seams()[0].closed_at);
  EXPECT_TRUE(simulation.seams()[0].due);
  EXPECT_EQ(1, simulation.seams()[1].open);
  EXPECT_GT(simulation.seams()[1].largest_gap, 0.2);
  EXPECT_FALSE(simulation.seams()[1].due) << "it may stay open";
}

TEST(SeamState, AreTheSameAfterResumingAndOnMoreDevices) {
  for (const bool automatic : {false, true}) {
    Scene s = side_by_side(0.02);
    s.time.automatic = automatic;
    const ScratchFolder folder;
    Simulation one(s, host_devices(1));
    while (one.step_number() < (automatic ? 3 : 8)) one.step();
    one.save(folder / "open.weft");
    sew(one, 100);
    for (int n = 0; n < 5; ++n) one.step();
    one.save(folder / "closed.weft");
    const std::optional<double> closed_at = one.seams()[0].closed_at;

    Simulation three(s, host_devices(3));
    while (three.step_number() < one.step_number()) three.step();
    EXPECT_EQ(one.state_hash(), three.state_hash());
    EXPECT_EQ(closed_at, three.seams()[0].closed_at);

    Simulation resumed(s, host_devices(2));
    resumed.resume(folder / "closed.weft");
    EXPECT_EQ(closed_at, resumed.seams()[0].closed_at);
    EXPECT_EQ(one.step_length(), resumed.step_length());
    resumed.resume(folder / "open.weft");
    EXPECT_FALSE(resumed.seams()[0].closed_at);
    while (resumed.step_number() < one.step_number()) resumed.step();
    EXPECT_EQ(one.state_hash(), resumed.state_hash());
    EXPECT_EQ(closed_at, resumed.seams()[0].closed_at);
  }
}

TEST(SeamState, WithoutWeldingAreClosedWithinTheThickness) {
  Scene s = side_by_side(0.02);
  s.seams[0].weld_distance = 0;
  s.materials[0].damping_mass = 10;
  const ScratchFolder folder;
  Simulation simulation(s, host_devices(1));
  EXPECT_EQ(4, simulation.seams()[0].open);
  while (!simulation.seams()[0].closed_at && simulation.frame_number() < 100)
    ASSERT_EQ(Failure::none, simulation.step().failure);
  const SeamState seam = simulation.seams()[0];
  EXPECT_GT(seam.largest_gap, 0);
  EXPECT_LE(seam.largest_gap, contact_thickness(s.contact));
  EXPECT_EQ(simulation.time(), seam.closed_at);
  EXPECT_FALSE(seam.due);
  simulation.save(folder / "closed.weft");
  Simulation resumed(s, host_devices(1));
  resumed.resume(folder / "closed.weft");
  EXPECT_EQ(seam.closed_at, resumed.seams()[0].closed_at);
}

/// Two panels around a box that is turned by 45 degrees, so that both seams lie across its edges.
/// A straight line between the vertices of a pair passes through the box.
Scene around_a_box() {
  Scene s = bare_scene();
  const double half = 0.1625, high = 0.2;
  s.cloths.push_back(panel(9, 5, {-half, -0.13, -high / 2}, {2 * half, 0, 0}, {0, 0, high}));
  s.cloths.push_back(panel(9, 5, {half, 0.13, -high / 2}, {-2 * half, 0, 0}, {0, 0, high}));
  s.cloths[0].name = "front";
  s.cloths[1].name = "back";
  for (int side = 0; side < 2; ++side) {
    s.seams.push_back(
        seam_of(0, column(9, 5, side == 0 ? 0 : 9), 1, column(9, 5, side == 0 ? 9 : 0), 3e-3));
    s.seams.back().stiffness = 1000;
    s.seams.back().ramp_time = 0.3;
  }
  Obstacle box;
  box.name = "box";
  const double r = 0.16 / std::numbers::sqrt2;  // half of the diagonal of its base
  box.mesh.positions = {{-r, 0, -0.2}, {0, -r, -0.2}, {r, 0, -0.2}, {0, r, -0.2},
                        {-r, 0, 0.2},  {0, -r, 0.2},  {r, 0, 0.2},  {0, r, 0.2}};
  for (Index k = 0; k < 4; ++k) {
    const Index next = (k + 1) % 4;
    box.mesh.triangles.push_back({{k, next, next + 4}});
    box.mesh.triangles.push_back({{k, next + 4, k + 4}});
  }
  box.mesh.triangles.push_back({{0, 2, 1}});
  box.mesh.triangles.push_back({{0, 3, 2}});
  box.mesh.triangles.push_back({{4, 5, 6}});
  box.mesh.triangles.push_back({{4, 6, 7}});
  s.obstacles.push_back(box);
  return s;
}

TEST(Seams, WeldAcrossAnEdgeOfABody) {
  Simulation simulation(around_a_box(), host_devices(2));
  sew(simulation, 50);
  expect_clear(simulation);
  for (int n = 0; n < 8; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
  expect_clear(simulation);
}

/// What was refused within a frame is part of a checkpoint, as it is not tried again in that frame.
TEST(Seams, BlockedPairsStayOpenAndResumeWithinAFrame) {
  Scene s = bare_scene();
  s.cloths.push_back(panel(3, 3, {-0.1, -0.1, -0.005}, {0.2, 0, 0}, {0, 0.2, 0}));
  s.cloths.push_back(panel(3, 3, {0.1, -0.1, 0.005}, {-0.2, 0, 0}, {0, 0.2, 0}));
  s.seams.push_back(seam_of(0, column(3, 3, 0), 1, column(3, 3, 3), 6e-3));
  Obstacle plate;
  plate.name = "plate";
  plate.mesh = make_box({1, 1, 1e-3}, {1, 1, 1});
  s.obstacles.push_back(plate);
  Simulation simulation(s, host_devices(1));
  while (simulation.step_number() < 50) ASSERT_EQ(Failure::none, simulation.step().failure);
  ASSERT_NE(0, simulation.step_number() % simulation.steps_per_frame());
  const SeamState seam = simulation.seams()[0];
  EXPECT_EQ(4, seam.open);
  EXPECT_LT(seam.largest_gap, 6e-3) << "near enough to be welded, but for the plate";
  EXPECT_TRUE(seam.due);
  EXPECT_FALSE(seam.closed_at);
  const ScratchFolder folder;
  simulation.save(folder / "a.weft");
  Simulation resumed(s, host_devices(2));
  resumed.resume(folder / "a.weft");
  EXPECT_EQ(simulation.state_hash(), resumed.state_hash());
  for (int n = 0; n < 6; ++n) {
    ASSERT_EQ(Failure::none, simulation.step().failure);
    ASSERT_EQ(Failure::none, resumed.step().failure);
    EXPECT_EQ(simulation.state_hash(), resumed.state_hash()) << n;
  }
  expect_clear(simulation);
}

/// The midpoint of an edge from a welded vertex into its panel has to lie on the edge as it is
/// after welding.
TEST(Seams, WeldedAtTheStartAreJoinedBeforeRefinement) {
  Scene s = side_by_side(1.5e-3);
  s.refinement = {Refinement::When::sewn, 1};
  Simulation simulation(s, host_devices(1));
  EXPECT_TRUE(simulation.seams()[0].closed_at);
  const Frame frame = simulation.frame();
  const auto& x = frame.cloth_positions[0];
  ASSERT_EQ(49u, x.size());
  const Vec3<double> seam = x[3], inner = x[2];
  EXPECT_NEAR(-0.75e-3, seam[0], 1e-12);
  const bool found = std::any_of(x.begin(), x.end(), [&](const Vec3<double>& p) {
    return length(p - 0.5 * (seam + inner)) < 1e-12;
  });
  EXPECT_TRUE(found);
  // A resumed run is refined from the same places.
  const ScratchFolder folder;
  simulation.step();
  simulation.save(folder / "a.weft");
  Simulation resumed(s, host_devices(1));
  resumed.resume(folder / "a.weft");
  EXPECT_EQ(simulation.state_hash(), resumed.state_hash());
  simulation.step();
  resumed.step();
  EXPECT_EQ(simulation.state_hash(), resumed.state_hash());
}

/// Four panels around a corner, sewn in a ring: the last pair of the corner closes a loop.
TEST(Seams, FourPanelsMeetInACorner) {
  Scene s = bare_scene();
  const double gap = 0.01;
  for (int k = 0; k < 4; ++k) {
    const bool right = k == 1 || k == 2, upper = k >= 2;
    s.cloths.push_back(
        panel(2, 2, {right ? gap / 2 : -0.2 - gap / 2, upper ? gap / 2 : -0.2 - gap / 2, 0},
              {0.2, 0, 0}, {0, 0.2, 0}));
  }
  const std::vector<Index> left{0, 3, 6}, right{2, 5, 8}, lower{0, 1, 2}, upper{6, 7, 8};
  s.seams.push_back(seam_of(0, right, 1, left, 2e-3));
  s.seams.push_back(seam_of(1, upper, 2, lower, 2e-3));
  s.seams.push_back(seam_of(2, left, 3, right, 2e-3));
  s.seams.push_back(seam_of(3, lower, 0, upper, 2e-3));
  Simulation simulation(s, host_devices(2));
  sew(simulation, 100);
  const Frame frame = simulation.frame();
  EXPECT_EQ(frame.cloth_positions[0][8], frame.cloth_positions[1][6]);
  EXPECT_EQ(frame.cloth_positions[0][8], frame.cloth_positions[2][0]);
  EXPECT_EQ(frame.cloth_positions[0][8], frame.cloth_positions[3][2]);
}

/// Three panels that meet in one edge, as at a pleat.
Scene pleat(double weld_distance) {
  Scene s = bare_scene();
  for (int k = 0; k < 3; ++k) {
    const double angle = 2 * std::numbers::pi * k / 3;
    const Vec3<double> out{std::cos(angle), std::sin(angle), 0};
    // Two of them end at the edge and one begins there, so that the pairs that are sewn first
    // agree in direction.
    s.cloths.push_back(panel(2, 2, 0.01 * out, 0.2 * out, {0, 0, 0.2}));
  }
  for (Index k = 0; k < 2; ++k)
    s.seams.push_back(seam_of(k, {0, 3, 6}, k + 1, {0, 3, 6}, weld_distance));
  return s;
}

TEST(Seams, ThreePanelsAreWeldedOnAnEdge) {
  for (const Bending bending : {Bending::plate, Bending::hinge}) {
    Scene s = pleat(2e-3);
    s.bending = bending;
    Simulation simulation(s, host_devices(2));
    sew(simulation, 50);
    for (int n = 0; n < 20; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
    const Frame frame = simulation.frame();
    for (std::size_t k = 1; k < 3; ++k)
      EXPECT_EQ(frame.cloth_positions[0][3], frame.cloth_positions[k][3]);
    expect_clear(simulation);
  }
}

TEST(Seams, ThreePanelsOnAnEdgeAreSewnWithoutWelding) {
  Scene s = pleat(0);
  s.materials[0].damping_mass = 10;
  Simulation simulation(s, host_devices(2));
  const auto open = [&] { return simulation.seams()[0].open + simulation.seams()[1].open; };
  for (int n = 0; n < 400 && open() > 0; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
  EXPECT_EQ(0, open());
  expect_clear(simulation);
}

/// A pocket: the outline of one panel is sewn onto lines within another, which have triangles on
/// both sides already.
TEST(Seams, APanelIsSewnOntoTheMiddleOfAnother) {
  for (const Bending bending : {Bending::plate, Bending::hinge}) {
    Scene s = bare_scene();
    s.bending = bending;
    s.cloths.push_back(panel(6, 6, {0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}));
    s.cloths.push_back(panel(2, 2, {0.1, 0.1, 0.01}, {0.1, 0, 0}, {0, 0.1, 0}));
    // Its triangle at a corner must not be that of the panel below.
    s.cloths[1].mesh.triangles[2] = {{1, 2, 4}};
    s.cloths[1].mesh.triangles[3] = {{2, 5, 4}};
    s.seams.push_back(seam_of(1, {6, 3, 0, 1, 2, 5, 8}, 0, {30, 23, 16, 17, 18, 25, 32}, 2e-3));
    s.pins.push_back({0, {42, 48}, {}});
    s.gravity = {0, 0, -9.81};
    Simulation simulation(s, host_devices(2));
    sew(simulation, 50);
    for (int n = 0; n < 20; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
    const Frame frame = simulation.frame();
    EXPECT_EQ(frame.cloth_positions[1][1], frame.cloth_positions[0][17]);
    expect_clear(simulation);
  }
}

/// A tube around a ball closes at any step, and while the ball moves. With welding at the end of
/// frames alone, pairs that have met go on pulling, and at short steps folds come in between.
TEST(Seams, CloseAroundAMovingBodyAtAnyStep) {
  for (const double step : {0.01, 0.0025, 0.00125}) {
    Scene s = bare_scene();
    s.precision = Precision::single_precision;
    s.gravity = {0, 0, -9.81};
    s.time.step = step;
    s.time.frame_rate = 25;
    const double half = 0.25, high = 0.4;
    s.cloths.push_back(panel(25, 20, {-half, -0.14, -high / 2}, {2 * half, 0, 0}, {0, 0, high}));
    s.cloths.push_back(panel(25, 20, {half, 0.14, -high / 2}, {-2 * half, 0, 0}, {0, 0, high}));
    for (const bool left : {true, false}) {
      s.seams.push_back(
          seam_of(0, column(25, 20, left ? 0 : 25), 1, column(25, 20, left ? 25 : 0), 3e-3));
      s.seams.back().stiffness = 1000;
      s.seams.back().ramp_time = 0.5;
    }
    Obstacle ball;
    ball.name = "ball";
    ball.mesh = make_icosphere(0.12, 2);
    ball.motion = {{0, {}}, {0.4, {{0.04, 0, 0}, {0, 0, 1}, 0, 1}}};
    s.obstacles.push_back(ball);
    Simulation simulation(s, host_devices(1));
    sew(simulation, 6);
    expect_clear(simulation);
  }
}

}  // namespace
}  // namespace weft
