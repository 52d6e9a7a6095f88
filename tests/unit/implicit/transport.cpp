#include <gtest/gtest.h>

#include "host/implicit/linear/pipelined_solve.hpp"
#include "weft/devices.hpp"

namespace weft {
namespace {

/// A device for what does not touch it, whose kernels reach others' memory or do not.
class Card final : public Device {
 public:
  explicit Card(bool reaches) : host_(host_devices(1)), reaches_(reaches) {}
  Backend backend() const noexcept override { return Backend::cuda; }
  std::string name() const override { return "card"; }
  Queue& compute() noexcept override { return host_[0].compute(); }
  Queue& transfer() noexcept override { return host_[0].transfer(); }
  bool reaches_peers() const noexcept override { return reaches_; }
  void* allocate(std::size_t) override { return nullptr; }
  void release(void*, std::size_t) noexcept override {}
  std::size_t peak_bytes() const noexcept override { return 0; }
  std::int64_t allocation_count() const noexcept override { return 0; }

 private:
  DeviceSet host_;
  bool reaches_;
};

DeviceSet two_gpus(bool reach) {
  std::vector<std::unique_ptr<Device>> gpus;
  for (int r = 0; r < 2; ++r) gpus.push_back(std::make_unique<Card>(reach));
  return DeviceSet(std::move(gpus));
}

TEST(Transport, AutomaticIsPeerWhereItWorks) {
  const SolverSettings settings;
  EXPECT_EQ(choose_transport(settings, host_devices(3)), Transport::peer);
  EXPECT_EQ(choose_transport(settings, two_gpus(true)), Transport::peer);
  EXPECT_EQ(choose_transport(settings, two_gpus(false)), Transport::pipelined);
}

TEST(Transport, WhatIsAskedForIsTaken) {
  SolverSettings settings;
  settings.transport = Transport::pipelined;
  EXPECT_EQ(choose_transport(settings, host_devices(1)), Transport::pipelined);
  settings.transport = Transport::peer;
  EXPECT_EQ(choose_transport(settings, two_gpus(false)), Transport::peer);
}

}  // namespace
}  // namespace weft
