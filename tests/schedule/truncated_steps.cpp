// Truncated steps on several ranks: their parts solve, exchange contacts and go back to the start
// of the step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr int cells = 4;
constexpr int steps = 14;

/// A napkin, one edge of which is carried onto the opposite one, where both are pinned.
Scene folded(Precision precision) {
  Scene s;
  s.precision = precision;
  s.materials.push_back(test::cotton());
  s.cloths.push_back(test::sheet(cells, 0));
  s.solver.partial_rows = 8;
  s.time.step = 0.01;
  Pin fixed, carried;
  for (Index v = 0; v <= cells; ++v) {
    fixed.vertices.push_back(v * (cells + 1));
    carried.vertices.push_back(v * (cells + 1) + cells);
  }
  carried.motion = {{0, {}}, {0.05, {{-0.2, 0, 0.2}}}, {0.1, {{-0.4, 0, 0}}}};
  s.pins = {fixed, carried};
  return s;
}

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
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const Scene scene = folded(precision);
    const Outcome one = run(scene, 1, 0);
    EXPECT_GT(one.truncations, 0);
    EXPECT_LE(one.distance, 2 * scene.contact.thickness);
    for (const int ranks : {2, 3, 5}) {
      const Outcome several = run(scene, ranks, ranks == 3 ? 1 : 0);
      EXPECT_EQ(one.hash, several.hash) << ranks << " ranks";
      EXPECT_EQ(one.truncations, several.truncations) << ranks << " ranks";
    }
  }
}

}  // namespace
}  // namespace weft
