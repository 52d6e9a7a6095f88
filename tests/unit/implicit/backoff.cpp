// Steps that begin in two halves since the solves of whole ones did not converge (Backoff).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

class BackoffTest : public testing::Test {
 protected:
  static constexpr int steps_ = 20;
  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "checkpoint.weft";
  Scene scene_ = scene_of_long_steps();

  /// A wavy sheet that hangs by two corners: solves of whole steps take far more iterations than
  /// those of halves, and they may take what is in between.
  static Scene scene_of_long_steps() {
    Scene s = test::hanging_sheet(Precision::double_precision, Integrator::implicit_euler);
    for (Vec3<double>& x : s.cloths[0].mesh.positions)
      x = {x[0] * (1 + 0.02 * std::sin(15 * x[1])), x[1] * (1 + 0.02 * std::sin(17 * x[0])),
           0.02 * std::sin(19 * x[0]) * std::sin(18 * x[1])};
    s.pins[1].motion.clear();
    s.time.step = 0.008;
    s.solver.preconditioner = Preconditioner::block_jacobi;
    s.solver.tolerance = 1e-8;
    s.solver.max_iterations = 10000;
    Scene half = s;
    half.time.step /= 2;
    const auto [fewest, most] = iterations(s, steps_);
    const auto [fewest_of_half, most_of_half] = iterations(half, 2 * steps_);
    EXPECT_LT(most_of_half, fewest)
        << "whole: up to " << most << ", halves: from " << fewest_of_half;
    s.solver.max_iterations = (fewest + most_of_half) / 2;
    return s;
  }
  /// Fewest and most that a solve of a step takes.
  static std::pair<int, int> iterations(const Scene& scene, int steps) {
    Simulation simulation(scene, host_devices(1));
    int fewest = std::numeric_limits<int>::max(), most = 0;
    for (int n = 0; n < steps; ++n) {
      const StepReport r = simulation.step();
      EXPECT_EQ(Failure::none, r.failure) << r.failure_detail;
      fewest = std::min(fewest, r.iterations_max);
      most = std::max(most, r.iterations_max);
    }
    return {fewest, most};
  }
};

TEST_F(BackoffTest, WholeOnesAreTriedAfterEverMoreSteps) {
  Simulation simulation(scene_, host_devices(1));
  std::vector<int> tried;
  for (int n = 0; n < steps_; ++n) {
    const StepReport r = simulation.step();
    ASSERT_EQ(Failure::none, r.failure) << r.failure_detail;
    EXPECT_EQ(FallbackLevel::halved, r.fallback_level) << "step " << n;
    if (r.retries > 0) tried.push_back(n);
  }
  EXPECT_EQ((std::vector<int>{0, 2, 5, 10, 19}), tried);
}

TEST_F(BackoffTest, EndWhereTheHalvesWouldHave) {
  Simulation backoff(scene_, host_devices(1));
  Scene half = scene_;
  half.time.step /= 2;
  Simulation by_halves(half, host_devices(1));
  for (int n = 0; n < steps_; ++n) {
    backoff.step();
    by_halves.step();
    by_halves.step();
    EXPECT_EQ(by_halves.state_hash(), backoff.state_hash()) << "step " << n;
  }
}

TEST_F(BackoffTest, ResumeBitForBit) {
  Simulation whole(scene_, host_devices(2));
  for (int n = 0; n < 7; ++n) whole.step();
  whole.save(file_);
  Simulation resumed(scene_, host_devices(1));
  resumed.resume(file_);
  for (int n = 7; n < steps_; ++n)
    EXPECT_EQ(whole.step().retries, resumed.step().retries) << "step " << n;
  EXPECT_EQ(whole.state_hash(), resumed.state_hash());
}

TEST_F(BackoffTest, EndOnceAWholeOneConverges) {
  Simulation failing(scene_, host_devices(1));
  for (int n = 0; n < 7; ++n) failing.step();
  failing.save(file_);
  scene_.solver.max_iterations = 10000;
  Simulation simulation(scene_, host_devices(1));
  simulation.resume(file_, SceneChanges::allow);
  // Of the four steps after that at 5 one has been done.
  for (int n = 7; n < 10; ++n)
    EXPECT_EQ(FallbackLevel::halved, simulation.step().fallback_level) << "step " << n;
  for (int n = 10; n < 14; ++n)
    EXPECT_EQ(FallbackLevel::whole, simulation.step().fallback_level) << "step " << n;
}

}  // namespace
}  // namespace weft
