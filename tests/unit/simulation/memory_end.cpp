// Memory of the host that ends within a step.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/replaced_new.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace {

constexpr long never = std::numeric_limits<long>::max();
thread_local long until_failure = never;  // allocations of this thread

}  // namespace

bool allocation_fails() {
  return until_failure != never && until_failure-- == 0;
}

namespace weft {
namespace {

/// Each allocation in turn, with memory left afterwards: the caller hears of it, and a state from
/// before leads to the same bits.
TEST(MemoryEnd, WithinAStepReachesTheCallerAndAStateGoesOn) {
  constexpr double frame = 0.02;
  Scene scene;
  scene.time.step = 0.01;
  scene.add(Cloth{.mesh = make_grid({0.4, 0.4}, {6, 6})});
  for (Vec3<double>& x : scene.cloths[0].mesh.positions) x += {0, 0, 0.005};
  scene.add(Obstacle{.mesh = make_grid({0.6, 0.6}, {4, 4})});
  scene.contact.thickness = 0.004;
  Simulation simulation(scene, host_devices(1));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(simulation.advance(frame));
  const std::string state = simulation.state();
  ASSERT_TRUE(simulation.advance(frame));
  const std::uint64_t expected = simulation.state_hash();
  int ended = 0;
  for (long k = 0;; k += 1 + k / 16) {
    simulation.restore(state);
    bool thrown = false;
    until_failure = k;
    try {
      simulation.advance(frame);
    } catch (const std::bad_alloc&) {
      thrown = true;
    } catch (const DeviceError&) {
      thrown = true;
    }
    const bool reached = until_failure == never || until_failure < 0;
    until_failure = never;
    if (!reached) break;
    if (!thrown) continue;  // something made do without
    ++ended;
    EXPECT_THROW(simulation.advance(frame), std::logic_error) << k;
    simulation.restore(state);
    ASSERT_TRUE(simulation.advance(frame)) << k;
    EXPECT_EQ(simulation.state_hash(), expected) << k;
  }
  EXPECT_GT(ended, 20);
}

}  // namespace
}  // namespace weft
