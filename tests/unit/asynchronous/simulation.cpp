// The asynchronous method behind weft::Simulation: checkpoints, devices, failures, rest.
#include "weft/simulation.hpp"
#include "host/base/scratch_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

Scene falling() {
  Scene s = asynchronous_scene();
  s.name = "falling";
  s.asynchronous.restitution = 0.2;
  s.contact.friction = 0.3;
  s.time.step = 0.007;
  s.time.frame_rate = 50;
  s.time.frames = 4;
  s.cloths.push_back(sheet(9, 0.108));
  s.cloths.push_back(sheet(8, 0.116));
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.1, 2);
  ball.motion = {{0, {}}, {0.1, {{0.02, 0, 0.02}, {0, 0, 1}, 0.5, 1}}};
  s.obstacles.push_back(ball);
  Pin pin;
  pin.vertices = {0, 9};
  pin.release_time = 0.045;
  s.pins = {pin};
  return s;
}

std::uint64_t run_on(int ranks, int steps) {
  Simulation simulation(falling(), host_devices(ranks));
  for (int k = 0; k < steps; ++k) EXPECT_EQ(simulation.step().failure, Failure::none);
  return simulation.state_hash();
}

TEST(AsynchronousSimulation, SameBitsOnAnyNumberOfThreads) {
  EXPECT_EQ(run_on(1, 6), run_on(2, 6));
}

TEST(AsynchronousSimulation, ResumesWithTheSameBits) {
  const ScratchFolder folder;
  const auto file = folder / "checkpoint.weft";
  Simulation whole(falling(), host_devices(1));
  for (int k = 0; k < 9; ++k) {
    if (k == 5) whole.save(file);
    ASSERT_EQ(whole.step().failure, Failure::none);
  }
  Simulation resumed(falling(), host_devices(1));
  resumed.resume(file);
  EXPECT_EQ(resumed.step_number(), 5);
  std::int64_t acting = 0;
  for (int k = 5; k < 9; ++k) {
    const StepReport report = resumed.step();
    ASSERT_EQ(report.failure, Failure::none);
    acting += report.asynchronous.acting_pairs;
  }
  EXPECT_GT(acting, 0);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
}

/// What is remembered of detections is in no checkpoint: a resumed run may begin other windows
/// ahead than the one that went on, and comes to the same.
TEST(AsynchronousSimulation, ResumesWithTheSameBitsWhateverWasBegunAhead) {
  Scene s = falling();
  s.asynchronous.window = 0.0007;
  const ScratchFolder folder;
  const auto file = [&](int k) { return folder / ("checkpoint_" + std::to_string(k) + ".weft"); };
  constexpr int steps = 12;
  Simulation whole(s, host_devices(2));
  std::vector<std::int64_t> started;
  std::int64_t held = 0;
  for (int k = 0; k < steps; ++k) {
    whole.save(file(k));
    const StepReport report = whole.step();
    ASSERT_EQ(report.failure, Failure::none);
    started.push_back(report.asynchronous.ahead_started);
    held += report.asynchronous.ahead_held;
  }
  EXPECT_GT(held, 0);
  int others = 0;
  for (const int from : {2, 5, 8, 10}) {
    Simulation resumed(s, host_devices(2));
    resumed.resume(file(from));
    for (int k = from; k < steps; ++k) {
      const StepReport report = resumed.step();
      ASSERT_EQ(report.failure, Failure::none);
      others += report.asynchronous.ahead_started != started[static_cast<std::size_t>(k)] ? 1 : 0;
    }
    EXPECT_EQ(resumed.state_hash(), whole.state_hash()) << from;
  }
  EXPECT_GT(others, 0) << "none began other windows";
}

/// What windows hold is booked, and what starts ahead take beside it: nothing on one thread.
TEST(AsynchronousSimulation, BooksWhatWindowsHold) {
  for (const int threads : {1, 2}) {
    Simulation simulation(falling(), host_devices(threads));
    for (int k = 0; k < 3; ++k) ASSERT_EQ(simulation.step().failure, Failure::none);
    std::size_t now = 0, ahead = 0;
    const auto uses = simulation.device_memory();
    for (const MemoryUse& use : uses[0]) {
      if (use.name == "windows") now = use.peak_bytes;
      if (use.name == "windows_ahead") ahead = use.peak_bytes;
    }
    EXPECT_GT(now, 10000u);
    EXPECT_EQ(ahead > 10000u, threads > 1) << threads;
    EXPECT_LE(ahead, now);
  }
}

TEST(AsynchronousSimulation, FailureLeavesTheStartOfTheStep) {
  Scene s = falling();
  s.asynchronous.layers = 1;
  s.cloths[1].velocity = {0, 0, -20};
  Simulation simulation(s, host_devices(1));
  StepReport report;
  std::uint64_t before = simulation.state_hash();
  for (int k = 0; k < 12 && report.failure == Failure::none; ++k) {
    before = simulation.state_hash();
    report = simulation.step();
  }
  EXPECT_EQ(report.failure, Failure::layers);
  EXPECT_EQ(report.fallback_level, FallbackLevel::failed);
  EXPECT_EQ(simulation.state_hash(), before);
}

TEST(AsynchronousSimulation, RefusesStepsThatForcesCannotTake) {
  Scene s = falling();
  s.asynchronous.smallest_step = 0.01;
  EXPECT_THROW(Simulation(s, host_devices(1)), SceneError);
  s = falling();
  s.precision = Precision::single_precision;
  EXPECT_THROW(Simulation(s, host_devices(1)), SceneError);
}

/// Walls close on a sheet until it is crumpled, then stand: it comes to rest in bounded work.
TEST(AsynchronousSimulation, SlowCompactorComesToRest) {
  Scene s = asynchronous_scene();
  s.name = "compactor";
  s.asynchronous.restitution = 0;
  s.contact.friction = 0.3;
  s.contact.thickness = 0.003;
  s.time.step = 0.01;
  s.materials[0].damping_mass = 2;
  s.cloths.push_back(sheet(14, 0.05));
  for (auto& x : s.cloths[0].mesh.positions) x[2] += 0.1 * x[0] + 0.05 * x[1];
  const auto wall = [&](Vec3<double> from, Vec3<double> to, Vec3<double> axis, double angle) {
    Obstacle o;
    o.name = "wall_" + std::to_string(s.obstacles.size());
    o.mesh = make_grid({0.8, 0.8}, {3, 3}, Diagonals::same);
    o.mesh.material.clear();
    o.motion = {{0, {from, axis, angle, 1}}, {1, {to, axis, angle, 1}}};
    s.obstacles.push_back(o);
  };
  const double right_angle = 1.5707963267948966;
  wall({0, 0, 0}, {0, 0, 1e-9}, {1, 0, 0}, 0);
  wall({0, 0, 0.2}, {0, 0, 0.09}, {1, 0, 0}, 0);
  wall({-0.23, 0, 0}, {-0.11, 0, 0}, {0, 1, 0}, right_angle);
  wall({0.23, 0, 0}, {0.11, 0, 0}, {0, 1, 0}, right_angle);
  wall({0, -0.23, 0}, {0, -0.11, 0}, {1, 0, 0}, right_angle);
  wall({0, 0.23, 0}, {0, 0.11, 0}, {1, 0, 0}, right_angle);
  Simulation simulation(s, host_devices(1));
  double most = 0;
  std::int64_t acting = 0;
  for (int k = 0; k < 300; ++k) {
    const StepReport report = simulation.step();
    ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
    most = std::max(most, simulation.energy().kinetic);
    acting = report.asynchronous.acting_pairs;
  }
  EXPECT_GT(acting, 0) << "nothing holds it";
  EXPECT_LT(simulation.energy().kinetic, 1e-2 * most);
}

}  // namespace
}  // namespace weft::test
