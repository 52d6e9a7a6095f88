// A step stands as a whole or not at all: one that fails or is stopped leaves the state as it was.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "host/implicit/step.hpp"
#include "host/state/checkpoint.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// Stops a step once some part of it has stood.
TEST(InterruptedStep, PartsThatStoodAreTakenBack) {
  Scene scene = test::thrown_sheet(20);
  scene.contact.zone_rounds = 1;
  scene.contact.substep_bisections = 12;
  std::atomic<bool> stop{false};
  DeviceSet devices = host_devices(2);
  devices.stop_on(&stop);
  Store<double> store(scene, devices);
  ImplicitStep<double> step(store);
  DeviceSet others = host_devices(1);
  Store<double> undisturbed(scene, others);
  ImplicitStep<double> same(undisturbed);
  int interrupted = 0;
  for (int n = 0; n < 12; ++n) {
    const StateSnapshot<double> before = store.snapshot();
    StepReport report;
    step.watch([&](const auto&, const auto&) { stop = report.retries > 0; });
    step.advance(scene.time.step, report);
    stop = false;
    if (report.failure == Failure::stopped) {
      ++interrupted;
      const StateSnapshot<double> after = store.snapshot();
      EXPECT_EQ(FallbackLevel::failed, report.fallback_level);
      EXPECT_EQ(hash_state(store.model(), before), hash_state(store.model(), after));
      EXPECT_EQ(before.time, after.time);
      EXPECT_EQ(before.previous_step, after.previous_step);
      EXPECT_EQ(before.backoff, after.backoff);
      step.watch({});
      report = {};
      step.advance(scene.time.step, report);
    }
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
    StepReport alone;
    same.advance(scene.time.step, alone);
    EXPECT_EQ(hash_state(undisturbed.model(), undisturbed.snapshot()),
              hash_state(store.model(), store.snapshot()))
        << "step " << n;
  }
  EXPECT_GT(interrupted, 0) << "no step is done in parts";
}

TEST(InterruptedStep, AFailedOneLeavesTheStateAsItWas) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision);
  scene.solver.tolerance = 1e-6;
  scene.solver.max_iterations = 1;
  Simulation simulation(scene, host_devices(2));
  for (int n = 0; n < 12; ++n) {
    const std::uint64_t hash = simulation.state_hash();
    const StepReport report = simulation.step();
    if (report.failure == Failure::none) continue;
    EXPECT_EQ(hash, simulation.state_hash());
    EXPECT_EQ(n, simulation.step_number());
    // The same again, from the same state.
    const StepReport again = simulation.step();
    EXPECT_EQ(report.failure, again.failure);
    EXPECT_EQ(report.retries, again.retries);
    return;
  }
  FAIL() << "no step failed";
}

/// A step that takes some seconds if nothing stops it.
Scene endless(const std::string& method, int cells = 60) {
  Scene s = test::sheet_on_sphere(Precision::double_precision, cells);
  s.solver.tolerance = 1e-7;
  s.solver.max_iterations = 1'000'000;
  s.solver.preconditioner = Preconditioner::block_jacobi;
  s.solver.newton_iterations = 1'000'000;
  s.solver.newton_tolerance = 1e-15;
  s.method = method;
  s.asynchronous.window = 0.003;
  s.asynchronous.stiffness = 1e6;
  return s;
}

void expect_stops(const Scene& scene, int ranks) {
  std::atomic<bool> stop{false};
  DeviceSet devices = host_devices(ranks);
  devices.stop_on(&stop);
  Simulation simulation(scene, std::move(devices));
  const std::uint64_t hash = simulation.state_hash();
  std::chrono::steady_clock::time_point asked;
  std::thread someone([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    asked = std::chrono::steady_clock::now();
    stop = true;
  });
  const StepReport report = simulation.step();
  someone.join();
  EXPECT_EQ(Failure::stopped, report.failure) << report.failure_detail;
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count(), 2);
  EXPECT_EQ(hash, simulation.state_hash());
  EXPECT_EQ(0, simulation.step_number());
}

TEST(InterruptedStep, StopsWithinNewtonsMethod) {
  for (const int ranks : {1, 3}) expect_stops(endless("implicit"), ranks);
}

TEST(InterruptedStep, StopsWithinALinearSolve) {
  Scene s = endless("implicit", 150);
  s.solver.newton_iterations = 1;
  s.solver.tolerance = 1e-15;
  for (const int ranks : {1, 3}) expect_stops(s, ranks);
}

TEST(InterruptedStep, StopsWithinAWindow) {
  Scene s = endless("asynchronous");
  s.time.step = 10;
  s.time.frame_rate = 0.1;
  expect_stops(s, 2);
}

TEST(InterruptedStep, AndIsThenDoneAsIfNothingHadBeen) {
  const Scene scene = test::sheet_on_sphere(Precision::single_precision, 10);
  std::atomic<bool> stop{false};
  DeviceSet devices = host_devices(2);
  devices.stop_on(&stop);
  Simulation simulation(scene, std::move(devices));
  Simulation undisturbed(scene, host_devices(2));
  for (int n = 0; n < 6; ++n) {
    stop = true;
    EXPECT_EQ(Failure::stopped, simulation.step().failure);
    stop = false;
    EXPECT_EQ(Failure::none, simulation.step().failure);
    undisturbed.step();
  }
  EXPECT_EQ(undisturbed.state_hash(), simulation.state_hash());
}

TEST(InterruptedStep, SettingUpStopsToo) {
  const std::atomic<bool> stop{true};
  DeviceSet devices = host_devices(1);
  devices.stop_on(&stop);
  EXPECT_THROW(
      Simulation(test::sheet_on_sphere(Precision::single_precision, 4), std::move(devices)),
      StoppedError);
}

}  // namespace
}  // namespace weft
