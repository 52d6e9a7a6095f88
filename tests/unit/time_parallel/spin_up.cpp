// Starts of slices that are not made of the state at their own step.
#include "host/time_parallel/spin_up.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/support/averaged_states.hpp"
#include "host/base/scratch_folder.hpp"
#include "host/time_parallel/slice_boundary.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "host/time_parallel/slices.hpp"
#include "tests/unit/time_parallel/memory_sink.hpp"
#include "tests/unit/time_parallel/scenes.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

namespace fs = std::filesystem;
using Steps = std::vector<std::int64_t>;

TEST(SpinUp, BeginsEverEarlier) {
  EXPECT_EQ(spin_up_starts(40, 4), (Steps{40, 36, 32, 24, 8, 0}));
  EXPECT_EQ(spin_up_starts(42, 4), (Steps{42, 40, 36, 28, 12, 0})) << "between two coarse steps";
  EXPECT_EQ(spin_up_starts(3, 4), (Steps{3, 0}));
  EXPECT_EQ(spin_up_starts(1, 1), (Steps{1, 0}));
  EXPECT_EQ(spin_up_starts(7, 2.5), (Steps{7, 5, 3, 0})) << "steps that coarse ones do not end at";
}

constexpr std::int64_t fine_steps = 4;  ///< a coarse one

/// A sheet that falls past a ball, and coarse states in which it has fallen into the ball.
class SpinUpTest : public ::testing::Test {
 protected:
  static Scene falling_sheet() {
    Scene scene = hanging_sheet(20);
    scene.pins.clear();
    scene.obstacles[0].transform.translate = {0, 0, -0.4};
    scene.time_parallel.coarsening = 2;
    scene.time_parallel.coarse_step = fine_steps * scene.time.step;
    return scene;
  }
  static Scene as_implicit(Scene scene) {
    scene.method = "implicit";
    return scene;
  }

  /// The serial run's states, but inside the ball from one coarse step to another.
  void SetUp() override {
    serial_.push_back(simulation_.frame());
    while (simulation_.frame_number() < fine_.time.frames) {
      ASSERT_EQ(simulation_.step().failure, Failure::none);
      serial_.push_back(simulation_.frame());
    }
  }
  void write_states(std::int64_t first_bad, std::int64_t last_bad, const fs::path& directory) {
    const bench::AveragedStates averages(fine_, level_);
    for (std::int64_t n = 0; n * fine_steps < static_cast<std::int64_t>(serial_.size()); ++n) {
      Frame frame = serial_[static_cast<std::size_t>(n * fine_steps)];
      if (n >= first_bad && n <= last_bad)
        for (Vec3<double>& x : frame.cloth_positions[0])
          x = Vec3<double>{0.1 * x[0], 0.1 * x[1], -0.4};
      averages.write(frame, directory, n);
    }
  }
  SliceStart start(std::function<bool(double)> go_on = {}) {
    if (!go_on) go_on = [](double) { return true; };
    return write_slice_start(fine_, level_, step, folder_.path(), file_, go_on);
  }
  Frame written() {
    Simulation simulation(fine_, host_devices(1));
    simulation.resume(file_);
    EXPECT_EQ(simulation.step_number(), step);
    return simulation.frame();
  }

  static constexpr std::int64_t step = 40;
  const ScratchFolder folder_;
  const fs::path file_ = folder_.path() / "start.weft";
  const Scene sheet_ = falling_sheet();
  const CoarseScene level_ = make_coarse_scene(sheet_);
  const Scene fine_ = as_implicit(sheet_);
  Simulation simulation_{fine_, host_devices(1)};
  std::vector<Frame> serial_;  ///< [steps + 1]
};

TEST_F(SpinUpTest, AStateThatIntersectsBeginsNoSlice) {
  write_states(9, 10, folder_.path());
  const SliceStart made = start();
  EXPECT_EQ(made.spin_up, step - 32) << "the last one that is free of intersections";
  EXPECT_NE(made.refused.find("step 40"), std::string::npos) << made.refused;
  EXPECT_NE(made.refused.find("inside"), std::string::npos) << made.refused;
  const Frame frame = written();
  EXPECT_TRUE(free_of_intersections(fine_, frame));
  EXPECT_LT(boundary_jump(fine_, serial_[step], frame).position, 0.02);
  EXPECT_FALSE(fs::exists(fs::path(file_).replace_extension("earlier")));
  // The work of what was tried and left counts too.
  write_states(100, 100, folder_.path());
  const SliceStart plain = start();
  EXPECT_EQ(plain.spin_up, 0);
  EXPECT_TRUE(plain.refused.empty());
  EXPECT_GT(made.work, plain.work);
}

TEST_F(SpinUpTest, InTheEndItIsTheRunFromItsStart) {
  write_states(1, 12, folder_.path());
  EXPECT_EQ(start().spin_up, step);
  const Frame frame = written();
  EXPECT_TRUE(frame.cloth_positions == serial_[step].cloth_positions) << "to the bit";
}

TEST_F(SpinUpTest, SameBitsForAnyNumberOfWorkers) {
  const TimeParallelScene scene(sheet_, 3);
  std::vector<std::uint64_t> first;
  for (const int workers : {1, 3}) {
    SliceOptions options;
    options.run = folder_.path() / std::to_string(workers);
    options.workers = workers;
    options.starts = {0, 22, step};
    options.devices = [](int) { return host_devices(1); };
    // States that are there are not made again.
    const fs::path coarse = SliceFiles::coarse(options.run);
    fs::create_directories(coarse);
    write_states(9, 10, coarse);
    write_work(coarse / "work.bin", std::vector<double>(17, 0));
    MemorySink sink;
    const SlicesOutcome outcome = run_slices(scene, options, sink);
    ASSERT_TRUE(outcome.done);
    EXPECT_EQ(outcome.slices[1].start.spin_up, 0);
    EXPECT_EQ(outcome.slices[2].start.spin_up, step - 32);
    for (const auto& [number, frame] : sink.frames)
      EXPECT_TRUE(free_of_intersections(fine_, frame)) << number;
    std::vector<std::uint64_t> states;
    for (int slice = 0; slice < 3; ++slice) {
      simulation_.resume(SliceFiles(options.run, slice).end());
      states.push_back(simulation_.state_hash());
    }
    if (workers == 1) first = states;
    EXPECT_EQ(states, first);
  }
}

TEST_F(SpinUpTest, MayBeStoppedBetweenSteps) {
  write_states(9, 10, folder_.path());
  double most = 0;
  start([&](double work) {
    most = work;
    return true;
  });
  fs::remove(file_);
  start([&](double work) { return work < 0.9 * most; });
  EXPECT_FALSE(fs::exists(file_));
}

}  // namespace
}  // namespace weft::test
