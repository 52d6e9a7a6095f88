// Penalty layers: what one of them does to a pair, when it is dropped, what friction adds up to;
// and how windows find their length.
#include "host/asynchronous/layers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/unit/asynchronous/brute_safety.hpp"
#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

/// A vertex above the middle of a face that is held, under one layer.
struct VertexOverFace {
  LayerForces forces{{0.01, 1000, 1e-4}, 0.5, {}, 1};
  VertexMotion motion;
  ActiveLayers layers;
  Histories trajectories;
  Workers workers{1};

  explicit VertexOverFace(double distance, const Vec3<double>& velocity) {
    motion.x = {{0, 0, distance}, {-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}};
    motion.v = {velocity, {}, {}, {}};
    motion.t.assign(4, 0);
    motion.inv_mass = {1 / 0.002, 0, 0, 0};
    layers.set({{{PrimitivePair::key_of(false, 0, 0), {0, 1, 2, 3}}, 1}});
    trajectories.reset(motion, 1, 0);
  }
  /// Velocity after a tick of 1e-4 s.
  Vec3<double> after() {
    layers.act(1, 1e-4, 0, forces, motion, trajectories, workers);
    return motion.v[0];
  }
};

/// h r (eta - d) / m on the way in, restitution^2 of that on the way out, nothing outside.
TEST(Layers, ImpulseOfOnePair) {
  const double full = 1e-4 * 1000 * 0.004 / 0.002;
  EXPECT_NEAR(VertexOverFace(0.006, {0, 0, -1}).after()[2], -1 + full, 1e-14);
  EXPECT_NEAR(VertexOverFace(0.006, {0, 0, 1}).after()[2], 1 + 0.25 * full, 1e-14);
  EXPECT_EQ(VertexOverFace(0.0101, {0, 0, -1}).after()[2], -1);
}

/// Coulomb's limit, and no more than stops the sliding.
TEST(Layers, FrictionOfOnePair) {
  const double full = 1e-4 * 1000 * 0.004 / 0.002;
  VertexOverFace fast(0.006, {0.3, 0.4, -1});
  fast.forces.friction = {0.9, 0.2, 0.2, 0.2};  // that of the face, which is no cloth
  const Vec3<double> braked = fast.after();
  EXPECT_NEAR(braked[0], 0.3 - 0.6 * 0.2 * full, 1e-14);
  EXPECT_NEAR(braked[1], 0.4 - 0.8 * 0.2 * full, 1e-14);
  VertexOverFace slow(0.006, {0.003, 0.004, -1});
  slow.forces.friction.assign(4, 0.2);
  EXPECT_NEAR(std::hypot(slow.after()[0], slow.after()[1]), 0, 1e-17);
}

TEST(Layers, AreDroppedWhereTheyExertNoForce) {
  VertexOverFace pair(0.006, {});
  pair.layers.set({{pair.layers.pairs()[0].pair, 5}});
  const LayerRule& rule = pair.forces.rule;
  EXPECT_EQ(pair.layers.deepest(), 5);
  pair.layers.set(pair.layers.kept(rule, pair.motion, 0, pair.workers));
  // 1.1 eta(5) = 7.4 mm is above 6 mm: all of them may act soon
  EXPECT_EQ(pair.layers.deepest(), 5);
  pair.motion.x[0] = {0, 0, 0.0095};
  pair.layers.set(pair.layers.kept(rule, pair.motion, 0, pair.workers));
  EXPECT_EQ(pair.layers.deepest(), 1) << "1.1 eta(2) = 9.2 mm";
  pair.motion.x[0] = {0, 0, 0.012};
  pair.layers.set(pair.layers.kept(rule, pair.motion, 0, pair.workers));
  EXPECT_EQ(pair.layers.deepest(), 0);
  EXPECT_TRUE(pair.layers.pairs().empty());
}

/// [kg m/s]
Vec3<double> momentum(const WindowRun& run) {
  Vec3<double> sum{};
  for (std::size_t i = 0; i < run.velocities.size(); ++i)
    sum += run.velocities[i] * run.model.mass[i];
  return sum;
}

/// A sheet that slides on a floor: while it does, friction takes mu times what the floor gives it
/// upwards, which is what weight and change of momentum say; then it stays where it is.
TEST(Friction, BrakesByCoulombsLaw) {
  Scene s = asynchronous_scene();
  s.asynchronous.restitution = 0;
  s.contact.friction = 0;
  s.materials[0].damping_mass = 0;
  s.cloths.push_back(sheet(4, 0.00401));
  s.cloths[0].velocity = {2, 0, 0};
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = make_grid({6, 6}, {2, 2}, Diagonals::same);
  floor.mesh.material.clear();
  floor.friction = 0.4;
  s.obstacles.push_back(floor);
  WindowRun run(s);
  const double mass = std::accumulate(run.model.mass.begin(),
                                      run.model.mass.begin() + run.model.cloth_vertex_count, 0.0);
  const Vec3<double> before = momentum(run);
  const auto floor_gave = [&](const Vec3<double>& now, double time) {
    return now[2] - before[2] + 9.81 * mass * time;
  };
  for (int k = 1; k <= 10; ++k) {
    const double time = 0.01 * k;
    ASSERT_TRUE(run.advance(time)) << run.total.failure_detail;
    const Vec3<double> now = momentum(run);
    const double braked = before[0] - now[0];
    // Layers tick in steps, gravity in other ones: off by what one tick of gravity gives.
    EXPECT_NEAR(braked, 0.4 * floor_gave(now, time), 0.4 * 9.81 * mass * 1e-3) << time;
    EXPECT_NEAR(now[1], 0, 1e-3 * before[0]);
  }
  EXPECT_GT(momentum(run)[0], 0) << "it should still slide";
  for (int k = 11; k <= 80; ++k) ASSERT_TRUE(run.advance(0.01 * k)) << run.total.failure_detail;
  // Nothing is left but hovering between two ticks of gravity.
  EXPECT_LT(length(momentum(run)), 9.81 * mass * 1e-3);
}

/// Without the layers that act, pairs in contact are too close: the validator of safety sees that.
TEST(BruteSafety, FindsPairsThatAreTooClose) {
  Scene s = asynchronous_scene();
  s.cloths.push_back(sheet(4, 0.0));
  s.cloths.push_back(sheet(3, 0.006));
  s.cloths[1].velocity = {0, 0, -1};
  for (const bool blind : {false, true}) {
    WindowRun run(s);
    BruteSafety judge;
    judge.without_layers = blind;
    judge.watch(run);
    ASSERT_TRUE(run.advance(0.004)) << run.total.failure_detail;
    EXPECT_GT(run.total.asynchronous.acting_pairs, 0);
    EXPECT_EQ(judge.violations > 0, blind);
  }
}

}  // namespace
}  // namespace weft::test
