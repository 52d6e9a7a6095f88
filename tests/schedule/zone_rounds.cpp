// Rounds of impact zones that begin where the ones before have ended, on several ranks: zones go
// from rank to rank between them, and some start again because a prescribed vertex gives way.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "host/exec/host_devices.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr int steps = 5;

/// Adds a sheet between two boxes that close on it, until they overlap by 2 cm.
/// @param x     [m] where
/// @param start [s] when
void add_press(Scene& scene, double x, double start) {
  const std::string number = std::to_string(scene.cloths.size());
  scene.cloths.push_back(test::sheet(6, 0));
  scene.cloths.back().name += number;
  for (auto& p : scene.cloths.back().mesh.positions) p[0] += x;
  for (const double side : {-1.0, 1.0}) {
    Obstacle o;
    o.name = (side < 0 ? "below" : "above") + number;
    o.mesh = make_box({0.2, 0.2, 0.1}, {4, 4, 2});
    o.motion = {{start, {{x, 0, 0.06 * side}}}, {start + 0.05, {{x, 0, 0.04 * side}}}};
    scene.obstacles.push_back(o);
  }
}

Scene presses(Precision precision) {
  Scene s;
  s.precision = precision;
  s.materials.push_back(test::cotton());
  s.contact.thickness = 0.004;
  s.contact.compliance_distance = std::numeric_limits<double>::infinity();
  s.solver.partial_rows = 8;
  s.time.step = 0.01;
  for (int k = 0; k < 3; ++k) add_press(s, 0.6 * k, 0.005 * k);
  return s;
}

struct Outcome {
  std::uint64_t hash = 0;
  std::int64_t passes = 0;
  int zones = 0, compliant = 0;
  int rounds = 0;  ///< most of a step
};

Outcome run(const Scene& scene, int ranks, std::uint64_t delay_seed) {
  Simulation simulation(scene, host_devices(ranks, {true, delay_seed}));
  Outcome out;
  for (int n = 0; n < steps; ++n) {
    const StepReport r = simulation.step();
    EXPECT_EQ(Failure::none, r.failure) << r.failure_detail;
    out.passes += r.zone_passes;
    out.zones = std::max(out.zones, r.zones);
    out.compliant = std::max(out.compliant, r.compliant);
    out.rounds = std::max(out.rounds, r.zone_rounds);
  }
  out.hash = simulation.state_hash();
  return out;
}

TEST(ZoneRounds, SameBitsWhereverZonesAreSolvedAndWhateverYields) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const Scene scene = presses(precision);
    const Outcome one = run(scene, 1, 0);
    EXPECT_GE(one.rounds, 2) << "rounds of a step";
    EXPECT_GE(one.zones, 3);
    EXPECT_GT(one.compliant, 0);
    for (const int ranks : {2, 3, 5, 8}) {
      const Outcome several = run(scene, ranks, ranks == 3 ? 1 : 0);
      EXPECT_EQ(one.hash, several.hash) << ranks << " ranks";
      EXPECT_EQ(one.passes, several.passes) << ranks << " ranks";
    }
  }
}

}  // namespace
}  // namespace weft
