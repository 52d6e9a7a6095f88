// Ranks on threads of the program's.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/support/small_scenes.hpp"
#include "weft/error.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// A thread for each piece of work, as a job system with enough workers would give it one.
class Threads {
 public:
  Executor executor() {
    return [this](std::function<void()> work) {
      const std::lock_guard lock(mutex_);
      threads_.emplace_back([this, work = std::move(work)] {
        work();
        ++done_;
      });
    };
  }
  std::size_t begun() const { return threads_.size(); }
  std::size_t done() const { return done_; }
  ~Threads() {
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  std::mutex mutex_;
  std::vector<std::thread> threads_;
  std::atomic<std::size_t> done_{0};
};

std::uint64_t hash_of(const Scene& scene, DeviceSet devices) {
  Simulation simulation(scene, std::move(devices));
  for (int k = 0; k < 4; ++k) EXPECT_EQ(simulation.step().failure, Failure::none);
  return simulation.state_hash();
}

TEST(Executor, RunsAllRanksWithTheSameBits) {
  const Scene scene = test::sheet_on_sphere(Precision::single_precision);
  const std::uint64_t own = hash_of(scene, host_devices(2));
  Threads threads;
  EXPECT_EQ(hash_of(scene, host_devices(2, threads.executor())), own);
  EXPECT_GT(threads.begun(), 0u);
}

TEST(Executor, HasNoWorkLeftOnceTheSimulationIsGone) {
  Threads threads;
  { const DeviceSet devices = host_devices(3, threads.executor()); }
  EXPECT_EQ(threads.begun(), 0u);
  for (int k = 0; k < 20; ++k) {
    const DeviceSet devices = host_devices(2, threads.executor());
    Buffer<int> a(devices[0], 1);
    int value = k;
    devices[0].compute().copy(a.data(), &value, sizeof value);
    devices[0].compute().sync();
    EXPECT_EQ(a.data()[0], k);
  }
}

TEST(Executor, IsNotCalledBySingleRanksAndMustExist) {
  Threads threads;
  hash_of(test::sheet_on_sphere(Precision::single_precision), host_devices(1, threads.executor()));
  EXPECT_EQ(threads.begun(), 0u);
  EXPECT_THROW(host_devices(2, Executor()), std::bad_function_call);
  EXPECT_THROW(host_devices(0, threads.executor()), DeviceError);
}

}  // namespace
}  // namespace weft
