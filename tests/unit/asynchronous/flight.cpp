// Invariants of the asynchronous method without and with self-contact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/state/energy.hpp"
#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

struct Momentum {
  Vec3<double> linear{}, angular{};
};

Momentum momentum(const WindowRun& run) {
  Momentum m;
  for (std::size_t i = 0; i < run.velocities.size(); ++i) {
    const Vec3<double> p = run.velocities[i] * run.model.mass[i];
    m.linear += p;
    m.angular += cross(run.positions[i], p);
  }
  return m;
}

double total_energy(const WindowRun& run) {
  const auto held = held_triangles(
      run.model, std::vector<unsigned char>(static_cast<std::size_t>(run.model.vertex_count), 0));
  const Energy e = measure_energy(run.scene, run.model, run.positions, run.velocities, {},
                                  make_plate(run.scene, run.model, held));
  return e.kinetic + e.elastic + e.gravitational;
}

/// Two sheets that fly at each other and spin, without gravity.
Scene flying_sheets(Bending bending) {
  Scene s = asynchronous_scene();
  s.bending = bending;
  s.gravity = {0, 0, 0};
  s.cloths.push_back(sheet(8, 0.0));
  s.cloths.push_back(sheet(7, 0.012));
  s.cloths[0].angular_velocity = {0.5, 2, 1};
  s.cloths[1].velocity = {0.05, 0.02, -0.8};
  s.cloths[1].angular_velocity = {1, -1, 3};
  return s;
}

/// One sheet, bent into a tube that is nearly closed.
Scene clapping_sheet(Bending bending) {
  Scene s = asynchronous_scene();
  s.bending = bending;
  s.gravity = {0, 0, 0};
  s.cloths.push_back(sheet(8, 0.0));
  for (auto& x : s.cloths[0].mesh.positions) {
    const double angle = x[0] / 0.066;
    x = {0.066 * std::sin(angle), x[1] + 0.03 * x[0], 0.066 * (1 - std::cos(angle))};
  }
  s.cloths[0].velocity = {0.3, -0.2, 0.1};
  s.cloths[0].angular_velocity = {2, 1, -1};
  return s;
}

class Flight : public testing::TestWithParam<Bending> {};

void expect_momentum_kept(WindowRun& run, int steps) {
  const Momentum before = momentum(run);
  double scale = 0;
  for (std::size_t i = 0; i < run.velocities.size(); ++i)
    scale += run.model.mass[i] * length(run.velocities[i]);
  for (int k = 1; k <= steps; ++k) ASSERT_TRUE(run.advance(0.005 * k)) << run.total.failure_detail;
  EXPECT_GT(run.total.asynchronous.acting_pairs, 100) << "nothing met";
  const Momentum after = momentum(run);
  EXPECT_LT(length(after.linear - before.linear), 1e-11 * scale);
  EXPECT_LT(length(after.angular - before.angular), 1e-11 * scale);
}

TEST_P(Flight, KeepsMomentumThroughContact) {
  WindowRun run(flying_sheets(GetParam()));
  expect_momentum_kept(run, 20);
}

TEST_P(Flight, KeepsMomentumThroughSelfContact) {
  WindowRun run(clapping_sheet(GetParam()));
  for (std::size_t i = 0; i < run.velocities.size(); ++i)
    run.velocities[i][0] -= std::copysign(10, run.positions[i][0]) * run.positions[i][2];
  run.windows.start(run.positions, run.velocities, 0);
  expect_momentum_kept(run, 40);
}

INSTANTIATE_TEST_SUITE_P(Both, Flight, testing::Values(Bending::plate, Bending::hinge));

TEST(Fall, IsExactAtTicks) {
  Scene s = asynchronous_scene();
  s.cloths.push_back(sheet(4, 1.0));
  WindowRun run(s);
  for (int k = 1; k <= 20; ++k) ASSERT_TRUE(run.advance(0.005 * k));
  for (std::size_t i = 0; i < run.velocities.size(); ++i)
    EXPECT_NEAR(run.positions[i][2], 1.0 - 0.5 * 9.81 * 0.1 * 0.1, 1e-12);
}

/// An undamped sheet that bounces on a floor again and again.
TEST(Bounce, EnergyStaysBounded) {
  Scene s = asynchronous_scene();
  s.cloths.push_back(sheet(6, 0.02));
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = make_grid({1, 1}, {2, 2}, Diagonals::same);
  floor.mesh.material.clear();
  floor.friction = 0;
  s.obstacles.push_back(floor);
  WindowRun run(s);
  const double before = total_energy(run);
  double least = before, most = before;
  std::vector<double> means;
  for (int second = 0; second < 6; ++second) {
    double sum = 0;
    for (int k = 1; k <= 100; ++k) {
      ASSERT_TRUE(run.advance(second + 0.01 * k)) << run.total.failure_detail;
      const double e = total_energy(run);
      sum += e / 100;
      least = std::min(least, e);
      most = std::max(most, e);
    }
    means.push_back(sum);
  }
  EXPECT_GT(run.total.asynchronous.acting_pairs, 1000);
  // What such steps conserve of an oscillation is 1 - (omega h)^2 / 4 of what its positions and
  // velocities say, and omega h is at most 1: as the bounces' energy goes over into ever stiffer
  // oscillations what is measured may rise by a third, and no further. What is not counted at all
  // is in the penalty layers while the sheet is on the floor.
  EXPECT_LT(most, before * 4 / 3);
  EXPECT_GT(least, before / 2);
  for (std::size_t k = 2; k < means.size(); ++k)
    EXPECT_NEAR(means[k], means[k - 1], 0.01 * before) << "second " << k;
}

}  // namespace
}  // namespace weft::test
