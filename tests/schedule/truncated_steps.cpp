// Truncated steps on several ranks: their parts solve, exchange contacts and go back to the start
// of the step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "host/exec/host_devices.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr int steps = 12;

struct Outcome {
  std::uint64_t hash = 0;
  int truncations = 0;
  double distance = 0;  ///< [m] that pins are from their places, at most
};

Outcome run(const Scene& scene, int ranks, std::uint64_t delay_seed) {
  Simulation simulation(scene, host_devices(ranks, {true, delay_seed}));
  Outcome out;
  for (int n = 0; n < steps; ++n) {
    const StepReport r = simulation.step();
    EXPECT_EQ(Failure::none, r.failure) << r.failure_detail;
    EXPECT_EQ(r.truncations > 0, r.fallback_level == FallbackLevel::truncated);
    out.truncations += r.truncations;
    out.distance = std::max(out.distance, r.compliance_distance);
  }
  out.hash = simulation.state_hash();
  return out;
}

TEST(TruncatedSteps, SameBitsOnAnyNumberOfRanks) {
  const Scene scene = test::folded_napkin(Precision::single_precision);
  const Outcome one = run(scene, 1, 0);
  EXPECT_GT(one.truncations, 0);
  EXPECT_LE(one.distance, 2 * contact_thickness(scene.contact));
  for (const int ranks : {2, 3}) {
    const Outcome several = run(scene, ranks, ranks == 3 ? 1 : 0);
    EXPECT_EQ(one.hash, several.hash) << ranks << " ranks";
    EXPECT_EQ(one.truncations, several.truncations) << ranks << " ranks";
  }
}

TEST(TruncatedSteps, ResumeWithTheSameBits) {
  const Scene scene = test::folded_napkin(Precision::single_precision);
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "weft_truncated_steps.weft";
  Simulation whole(scene, host_devices(1));
  Simulation resumed(scene, host_devices(1));
  bool stopped = false;
  for (int n = 0; n < steps; ++n) {
    const bool truncated = whole.step().truncations > 0;
    if (stopped) {
      resumed.step();
    } else if (truncated) {
      stopped = true;
      whole.save(file, false);
      resumed.resume(file);
      std::filesystem::remove(file);
    }
    if (stopped) {
      EXPECT_EQ(whole.state_hash(), resumed.state_hash()) << "step " << n;
    }
  }
  EXPECT_TRUE(stopped);
}

}  // namespace
}  // namespace weft
