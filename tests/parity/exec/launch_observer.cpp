#include "weft/exec/launch_observer.hpp"

#include <typeinfo>
#include <vector>

#include "tests/parity/support.hpp"
#include "weft/kernels/integrate/prescribe.hpp"

namespace weft::parity {
namespace {

using Kernel = IntegratePrescribe<float>;

/// What it was told, in order; it does not mind work and waits of its own.
class Witness final : public LaunchObserver {
 public:
  void before(Queue& queue) override {
    queue.stamp(&start_);
    told.push_back(nullptr);
  }
  void after(Queue& queue, const std::type_info& kernel, const void* args) override {
    queue.stamp(&end_);
    queue.sync();
    told.push_back(&kernel);
    targets = static_cast<const Kernel*>(args)->targets.size();
    in_order = in_order && start_ <= end_;
  }

  std::vector<const std::type_info*> told;
  std::size_t targets = 0;
  bool in_order = true;

 private:
  double start_ = 0, end_ = 0;
};

void see_launches(Device& device) {
  const std::vector<MovedVertex<float>> wanted = {{2, {1, 2, 3}}, {0, {4, 5, 6}}};
  Buffer<MovedVertex<float>> targets = upload(device, wanted);
  Buffer<Vec3<float>> positions = upload(device, std::vector<Vec3<float>>(3));
  const Kernel args{targets.span(), positions.span()};
  Witness witness;
  LaunchObserver::current = &witness;
  launch(device.compute(), args);
  LaunchObserver::current = nullptr;
  launch(device.compute(), args);
  device.compute().sync();
  ASSERT_EQ(witness.told.size(), 2u);
  EXPECT_EQ(witness.told[0], nullptr);
  EXPECT_TRUE(*witness.told[1] == typeid(Kernel));
  EXPECT_EQ(witness.targets, 2u);
  EXPECT_TRUE(witness.in_order);
  EXPECT_EQ(download(positions), (std::vector<Vec3<float>>{{4, 5, 6}, {}, {1, 2, 3}}));
}

TEST(LaunchObserver, SeesLaunchesOnTheHost) {
  DeviceSet devices = host_devices(1);
  see_launches(devices[0]);
}

TEST(LaunchObserver, SeesLaunchesOnCuda) {
  std::string why;
  std::optional<DeviceSet> devices = find_cuda({0}, why);
  if (!devices) GTEST_SKIP() << why;
  see_launches((*devices)[0]);
}

}  // namespace
}  // namespace weft::parity
