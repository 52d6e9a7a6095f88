// Recovery of detail by itself: from a coarse run that goes where the fine one goes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "benchmarks/support/averaged_states.hpp"
#include "host/base/scratch_folder.hpp"
#include "host/time_parallel/slice_boundary.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "tests/unit/time_parallel/scenes.hpp"
#include "weft/devices.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

namespace fs = std::filesystem;

constexpr int coarsening = 5;

/// A sheet that swings without touching anything, and bends smoothly over some fine cells.
Scene swinging_sheet() {
  Scene scene = hanging_sheet(40);
  scene.obstacles.clear();
  scene.materials[0].bending_stiffness = 1e-4;
  scene.materials[0].damping_stiffness = 5e-4;
  scene.time_parallel.coarsening = coarsening;
  scene.time_parallel.coarse_step = 0.02;
  return scene;
}

/// The serial run, and coarse states that are averages of its own.
class RecoveryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const bench::AveragedStates averages(fine_, level_);
    Simulation serial(fine_, host_devices(1));
    serial_.push_back(serial.frame());
    while (serial.frame_number() < fine_.time.frames) {
      ASSERT_EQ(serial.step().failure, Failure::none);
      serial_.push_back(serial.frame());
    }
    constexpr std::int64_t fine_steps = 4;  // a coarse one
    for (std::int64_t n = 0; n * fine_steps < static_cast<std::int64_t>(serial_.size()); ++n)
      averages.write(serial_[static_cast<std::size_t>(n * fine_steps)], folder_.path(), n);
  }

  static Scene as_implicit(Scene scene) {
    scene.method = "implicit";
    return scene;
  }

  /// @param iterations -1: as the scene has it
  fs::path start_at(std::int64_t step, int iterations) {
    Scene scene = fine_;
    if (iterations >= 0) scene.time_parallel.recovery_iterations = iterations;
    const fs::path file = folder_.path() / "start.weft";
    start_ =
        write_slice_start(scene, level_, step, folder_.path(), file, [](double) { return true; });
    return file;
  }
  Frame after(const fs::path& start, int steps) {
    Simulation simulation(fine_, host_devices(1));
    simulation.resume(start);
    for (int k = 0; k < steps; ++k) EXPECT_EQ(simulation.step().failure, Failure::none);
    return simulation.frame();
  }

  const ScratchFolder folder_;
  const Scene sheet_ = swinging_sheet();
  const CoarseScene level_ = make_coarse_scene(sheet_);
  const Scene fine_ = as_implicit(sheet_);
  std::vector<Frame> serial_;  ///< [steps + 1]
  SliceStart start_;
};

// An arc in chords of r edges each: r - 1 edges out of r lack their angle, and one has r of them.
TEST_F(RecoveryTest, FacetsOfTheCoarseMeshAreGone) {
  constexpr std::int64_t step = 48;
  const Frame& wanted = serial_[step];
  const double before = curvature_error(fine_, wanted, after(start_at(step, 0), 0));
  EXPECT_NEAR(before, 2.0 * (coarsening - 1) / coarsening, 0.1);
  const double recovered = curvature_error(fine_, wanted, after(start_at(step, -1), 0));
  EXPECT_LT(recovered, 0.4 * before);
  EXPECT_GT(start_.iterations, 0);
  EXPECT_LT(start_.iterations, start_.iterations_max);
}

TEST_F(RecoveryTest, SlicesGoOnWhereTheSerialRunGoes) {
  constexpr std::int64_t step = 36;
  constexpr int later = 24;
  const Frame& wanted = serial_[step + later];
  const BoundaryJump plain = boundary_jump(fine_, wanted, after(start_at(step, 0), later));
  const BoundaryJump recovered = boundary_jump(fine_, wanted, after(start_at(step, -1), later));
  EXPECT_LT(recovered.position_rms, 0.5 * plain.position_rms);
  EXPECT_LT(recovered.curvature, 0.05);
  // Steps at the speed of the coarse run's last step would be half of it late: 10 ms of gravity.
  EXPECT_LT(recovered.position_rms, 0.1 * later * fine_.time.step * 9.81 * 0.01);
}

TEST_F(RecoveryTest, VelocitiesAreThoseOfTheCoarseRunAtThatTime) {
  constexpr std::int64_t step = 38;  // halfway between two coarse ones
  CoarseStates states(level_, folder_.path());
  const auto wanted = states.fine_state(static_cast<double>(step) * fine_.time.step).velocities;
  const Frame start = after(start_at(step, -1), 0);
  std::size_t other = 0;
  for (std::size_t v = 0; v < wanted.size(); ++v)
    other += length(start.cloth_velocities[0][v] - wanted[v]) > 1e-12 ? 1 : 0;
  EXPECT_LE(other, 2u) << "but for the two pinned ones";
}

}  // namespace
}  // namespace weft::test
