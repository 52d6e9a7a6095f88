// The benchmark's way of exchanging vectors: all copies of the work queues, then the product.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "benchmarks/support/grid_system.hpp"
#include "host/exec/host_devices.hpp"

namespace weft {
namespace {

std::vector<Vec3<float>> solution(int ranks, Transport transport, bool gather,
                                  std::uint64_t delay_seed = 0) {
  Scene scene = wavy_sheet(24);
  scene.solver.preconditioner = Preconditioner::block_jacobi;
  scene.solver.transport = transport;
  scene.solver.tolerance = 1e-3;
  HostDeviceOptions options;
  options.poison = true;
  options.delay_seed = delay_seed;
  FirstSystem<float> system(scene, host_devices(ranks, options), true);
  system.gather_before_products(gather);
  if (delay_seed != 0) system.settings().max_iterations = 10;
  system.assemble();
  system.solve();
  system.sync();
  return system.velocities();
}

bool same_bits(const std::vector<Vec3<float>>& a, const std::vector<Vec3<float>>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

TEST(Gathered, SameBitsAsPeer) {
  const std::vector<Vec3<float>> peer = solution(1, Transport::peer, false);
  for (const int ranks : {1, 2, 3, 5, 8}) {
    EXPECT_TRUE(same_bits(peer, solution(ranks, Transport::pipelined, true))) << ranks;
    EXPECT_TRUE(same_bits(peer, solution(ranks, Transport::pipelined, false))) << ranks;
  }
}

TEST(Gathered, ShuffledTiming) {
  const std::vector<Vec3<float>> calm = solution(1, Transport::pipelined, true, 1);
  for (const int ranks : {3, 8})
    EXPECT_TRUE(same_bits(calm, solution(ranks, Transport::pipelined, true, 2))) << ranks;
}

}  // namespace
}  // namespace weft
