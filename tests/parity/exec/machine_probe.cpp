// What GPUs and links of this machine are measured to do: figures that hardware can have, in time.
#include "weft/exec/machine_probe.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/parity/support.hpp"
#include "weft/scene.hpp"

namespace weft::parity {
namespace {

#if defined(WEFT_CUDA)
using Clock = std::chrono::steady_clock;

class Probe : public testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    if (!find_cuda({0}, why)) GTEST_SKIP() << why;
    probe_ = cuda_machine_probe();
    ASSERT_GE(probe_->gpu_count(), 1);
    EXPECT_EQ(probe_->why_none(), "");
  }
  void expect_copies(const LinkFigures& link) {
    EXPECT_GT(link.copy_latency, 1e-7);
    EXPECT_LT(link.copy_latency, 1e-3);
    EXPECT_GT(link.copy_bandwidth, 1e9);
    EXPECT_LT(link.copy_bandwidth, 1e13);
  }
  std::unique_ptr<MachineProbe> probe_;
};

TEST_F(Probe, GpuAlone) {
  EXPECT_NE(probe_->name(0), "");
  const double bandwidth = probe_->bandwidth(0);
  EXPECT_GT(bandwidth, 1e10);
  EXPECT_LT(bandwidth, 2e13);
  // Within a GPU there is a way for copies, and no other GPU to reach.
  const LinkFigures self = probe_->link(0, 0);
  EXPECT_FALSE(self.peer);
  expect_copies(self);
}

TEST_F(Probe, LinksOfCards) {
  if (probe_->gpu_count() < 2) GTEST_SKIP() << "one GPU";
  probe_->link(0, 1);  // wakes both
  const auto start = Clock::now();
  const LinkFigures link = probe_->link(0, 1);
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  EXPECT_LT(seconds, 0.5);
  expect_copies(link);
  if (!link.peer) return;
  EXPECT_GT(link.load_latency, 1e-7);
  EXPECT_LT(link.load_latency, 1e-4);
  EXPECT_GT(link.load_bandwidth, 1e9);
  EXPECT_LT(link.load_bandwidth, 1e13);
}

TEST_F(Probe, ASmallSceneTakesOneCard) {
  Scene scene;
  scene.cloths.resize(1);
  scene.cloths.front().mesh.positions.resize(65'000);
  const DeviceChoice choice = choose_devices(scene);
  EXPECT_EQ(choice.device, "cuda:0") << choice.reason;
  EXPECT_FALSE(choice.figures.empty());
  EXPECT_FALSE(choice.estimates.empty());
}

TEST_F(Probe, ALargeSceneTakesNoMissingCard) {
  Scene scene;
  scene.cloths.resize(1);
  scene.cloths.front().mesh.positions.resize(2'000'000);
  const DeviceChoice choice = choose_devices(scene);
  EXPECT_LE(parse_devices(choice.device).size(), probe_->gpu_count());
}
#endif

}  // namespace
}  // namespace weft::parity
