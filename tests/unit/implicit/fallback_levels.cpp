// The fallback levels that a step goes down when its impacts will not resolve, each forced by
// taking away the ones above, and what the report says of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/implicit/step_failure.hpp"
#include "host/scene/intersection_check.hpp"
#include "tests/support/jittered.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

void expect_untangled(const Scene& scene, const Frame& frame) {
  Scene now = scene;
  for (std::size_t c = 0; c < now.cloths.size(); ++c)
    now.cloths[c].mesh.positions = frame.cloth_positions[c];
  EXPECT_NO_THROW(refuse_intersecting_start(now)) << "frame " << frame.number;
}

struct Ladder {
  StepReport sum;  ///< counts of all steps, and the lowest fallback level
  bool consistent = true;
};

/// Runs some steps, none of which may fail.
Ladder climb_down(const Scene& scene, int steps) {
  Simulation simulation(scene, host_devices(1));
  Ladder ladder;
  StepReport& sum = ladder.sum;
  for (int n = 0; n < steps; ++n) {
    const StepReport r = simulation.step();
    EXPECT_EQ(Failure::none, r.failure) << r.failure_detail << " at " << r.time;
    if (r.failure != Failure::none) break;
    expect_untangled(scene, simulation.frame());
    sum.retries += r.retries;
    sum.zone_rounds += r.zone_rounds;
    sum.zones = std::max(sum.zones, r.zones);
    sum.zone_largest = std::max(sum.zone_largest, r.zone_largest);
    sum.zone_passes += r.zone_passes;
    sum.zone_visits += r.zone_visits;
    sum.zones_unsolved += r.zones_unsolved;
    sum.plane_zones += r.plane_zones;
    sum.rigid_zones += r.rigid_zones;
    sum.fallback_level = std::max(sum.fallback_level, r.fallback_level);
    const FallbackLevel expected = r.rigid_zones > 0 ? FallbackLevel::rigid
                                   : r.retries > 0   ? FallbackLevel::halved
                                                     : FallbackLevel::whole;
    ladder.consistent = ladder.consistent && r.fallback_level == expected;
  }
  return ladder;
}

/// The fallback table of ARCHITECTURE.md.
TEST(Ladder, AFailedAttemptIsHalvedOrTruncatedOrTheLast) {
  struct Row {
    Failure failure;
    int bisections_left;
    std::int64_t budget;
    Fallback next;
  };
  for (const Row& row : {Row{Failure::contact_motion, 1, 0, Fallback::halve},
                         Row{Failure::not_converged, 1, 0, Fallback::halve},
                         Row{Failure::not_converged, 0, 1, Fallback::fail},
                         Row{Failure::not_finite, 0, 1, Fallback::fail},
                         Row{Failure::intersection, 1, 1, Fallback::halve},
                         Row{Failure::intersection, 1, 0, Fallback::truncate},
                         Row{Failure::intersection, 0, 1, Fallback::truncate},
                         Row{Failure::pinched, 0, 1, Fallback::truncate},
                         Row{Failure::stopped, 1, 1, Fallback::fail}}) {
    StepReport report;
    report.failure = row.failure;
    EXPECT_EQ(row.next, after_failure(report, row.bisections_left, row.budget))
        << describe(row.failure) << " with " << row.bisections_left << " bisections left";
  }
}

TEST(Ladder, ZonesAloneAreEnoughMostOfTheTime) {
  const Ladder ladder = climb_down(test::thrown_sheet(20), 12);
  EXPECT_EQ(FallbackLevel::whole, ladder.sum.fallback_level);
  EXPECT_TRUE(ladder.consistent);
  EXPECT_GT(ladder.sum.zone_rounds, 0);
  EXPECT_GT(ladder.sum.zones, 0);
  EXPECT_GT(ladder.sum.zone_largest, 1);
  EXPECT_GT(ladder.sum.zone_passes, 0);
  EXPECT_GT(ladder.sum.zone_visits, ladder.sum.zone_passes) << "zones of several collisions";
  EXPECT_EQ(0, ladder.sum.retries);
  EXPECT_EQ(0, ladder.sum.rigid_zones);
}

TEST(Ladder, AStepThatMayNotGoOnIsHalved) {
  Scene scene = test::thrown_sheet(20);
  scene.contact.zone_rounds = 1;
  scene.contact.substep_bisections = 12;
  const Ladder ladder = climb_down(scene, 12);
  EXPECT_EQ(FallbackLevel::halved, ladder.sum.fallback_level);
  EXPECT_TRUE(ladder.consistent);
  EXPECT_GT(ladder.sum.retries, 0);
  EXPECT_EQ(0, ladder.sum.rigid_zones);
}

TEST(Ladder, AtTheFloorZonesMoveAsRigidBodies) {
  Scene scene = test::thrown_sheet(15);
  scene.contact.substep_bisections = 0;
  // Only the first rounds may do otherwise.
  scene.contact.zone_rounds = 5;
  const Ladder ladder = climb_down(scene, 8);
  EXPECT_EQ(FallbackLevel::rigid, ladder.sum.fallback_level);
  EXPECT_TRUE(ladder.consistent);
  EXPECT_EQ(0, ladder.sum.retries);
  EXPECT_GT(ladder.sum.rigid_zones, 0);
}

TEST(Ladder, ZonesKeepTheMomentumOfTheStep) {
  Scene scene = test::thrown_sheet(60);
  scene.solver.tolerance = 1e-13;
  Simulation simulation(scene, host_devices(1));
  // All triangles of a sheet are alike, and each gives a third of its mass to each corner.
  const auto momentum = [&] {
    const Frame frame = simulation.frame();
    Vec3<double> sum{};
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
      const auto& mesh = scene.cloths[c].mesh;
      const double mass = scene.materials[0].density * 0.16;
      for (const Tri& t : mesh.triangles)
        for (const Index v : t.v)
          sum += (mass / static_cast<double>(3 * mesh.triangles.size())) *
                 frame.cloth_velocities[c][static_cast<std::size_t>(v)];
    }
    return sum;
  };
  const Vec3<double> before = momentum();
  int rounds = 0;
  for (int n = 0; n < 8; ++n) {
    const StepReport r = simulation.step();
    ASSERT_EQ(Failure::none, r.failure);
    rounds += r.zone_rounds;
  }
  EXPECT_GT(rounds, 0);
  // The solves hold theirs to their tolerance only: 1e-13 a solve, relative to forces far greater.
  EXPECT_LE(length(momentum() - before), 1e-9 * length(before));
}

/// Cloth with edges of 125 mm slides over a ball with edges of 18 mm: impact zones hold back whole
/// triangles. In steps that are too short for what gravity does to matter, too, they may not gain
/// energy several times over, which crumples the cloth in steps that follow. Three iterations of
/// Newton's method do not converge here: some starts gain energy without zones.
TEST(Ladder, ShortStepsGainNoEnergyOfZones) {
  Scene s;
  Material cotton;
  cotton.density = 0.15;
  cotton.stretch_stiffness = 800;
  cotton.bending_stiffness = 1e-5;
  cotton.damping_stiffness = 5e-4;
  s.materials.push_back(cotton);
  s.precision = Precision::single_precision;
  s.time = {0.01, 100, 50};
  s.solver.newton_iterations = 3;
  s.bending = Bending::plate;
  Cloth cloth;
  cloth.name = "cloth";
  cloth.mesh = make_grid({1, 1}, {8, 8}, Diagonals::alternating);
  for (Vec3<double>& x : cloth.mesh.positions) x[2] = 0.27;
  s.cloths.push_back(cloth);
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.25, 4);
  ball.friction = 0.5;
  s.obstacles.push_back(ball);
  constexpr unsigned starts = 5;
  std::vector<double> most;
  for (unsigned start = 0; start < starts; ++start) {
    Simulation simulation(jittered(s, start), host_devices(1));
    const auto total = [&] {
      const Energy e = simulation.energy();
      return e.kinetic + e.elastic + e.gravitational;
    };
    const double first = total();
    most.push_back(0);
    int impacts = 0;
    for (int n = 0; n < 50; ++n) {
      const StepReport r = simulation.step();
      ASSERT_EQ(Failure::none, r.failure) << r.failure_detail << " at " << r.time;
      impacts += static_cast<int>(r.impacts);
      most.back() = std::max(most.back(), total() / first);
    }
    EXPECT_GT(impacts, 0);
  }
  std::sort(most.begin(), most.end());
  EXPECT_LT(most[starts / 2], 1.02);
  EXPECT_LT(most.back(), 2);
}

}  // namespace
}  // namespace weft
