#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "host/exec/host_devices.hpp"
#include "host/implicit/step.hpp"
#include "host/state/checkpoint.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

/// Which rows and queries a rank has must not change a bit, whenever that changes.
namespace weft {
namespace {

constexpr int steps = 24;

std::uint64_t hash_of_run(const Scene& scene, int ranks, std::uint64_t delay_seed, int count,
                          BalanceReport* balance = nullptr) {
  Simulation simulation(scene, host_devices(ranks, {true, delay_seed}));
  for (int k = 0; k < count; ++k) {
    const StepReport r = simulation.step();
    EXPECT_EQ(r.failure, Failure::none);
    if (balance != nullptr) *balance += r.balance;
  }
  return simulation.state_hash();
}

Scene with(Scene scene, Rebalance rebalance) {
  scene.solver.rebalance = rebalance;
  return scene;
}

void expect_same_bits(const Scene& scene) {
  const std::uint64_t one = hash_of_run(with(scene, Rebalance::never), 1, 0, steps);
  BalanceReport balance;
  for (const int ranks : {2, 3, 5, 8})
    EXPECT_EQ(one, hash_of_run(with(scene, Rebalance::every_step), ranks, 0, steps, &balance))
        << ranks;
  EXPECT_GT(balance.rebalances, 0);
  EXPECT_GE(balance.imbalance_before, balance.imbalance_after);
}

TEST(Rebalance, EveryStep) {
  expect_same_bits(test::sheet_on_sphere(Precision::single_precision));
}

TEST(Rebalance, EveryStepTwoSheetsDouble) {
  expect_same_bits(test::two_sheets(Precision::double_precision));
}

TEST(Rebalance, EveryStepPipelined) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 10);
  scene.solver.transport = Transport::pipelined;
  expect_same_bits(scene);
}

TEST(Rebalance, EveryStepNewtonInTheWind) {
  Scene scene = test::sheet_on_sphere(Precision::double_precision, 10);
  scene.solver.newton_iterations = 4;
  scene.wind = {1.2, {2, 1, 0}, 0.05};
  expect_same_bits(scene);
}

TEST(Rebalance, EveryStepAllPreconditioners) {
  for (const Preconditioner preconditioner :
       {Preconditioner::block_jacobi, Preconditioner::multilevel}) {
    Scene scene = test::sheet_on_sphere(Precision::single_precision, 14);
    scene.solver.preconditioner = preconditioner;
    expect_same_bits(scene);
  }
}

TEST(Rebalance, ShuffledTiming) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision, 10);
  const std::uint64_t calm = hash_of_run(with(scene, Rebalance::never), 1, 0, 8);
  for (const int ranks : {2, 3, 8})
    EXPECT_EQ(calm, hash_of_run(with(scene, Rebalance::every_step), ranks, 1, 8)) << ranks;
}

/// Cuts anywhere, some ranks without rows, as numbers of a generator say.
std::vector<Index> any_cut(const Partition& partition, unsigned& state) {
  std::vector<Index> begin = partition.row_begin;
  for (std::size_t r = 1; r + 1 < begin.size(); ++r) {
    state = state * 1664525u + 1013904223u;
    const auto partials = static_cast<unsigned>(partition.row_count() / partition.partial_rows) + 1;
    begin[r] = std::min(partition.row_count(),
                        static_cast<Index>(state / 65536u % partials) * partition.partial_rows);
  }
  std::sort(begin.begin() + 1, begin.end() - 1);
  return begin;
}

/// @param cut_every steps after which rows are redistributed, at any place; 0: never
template <class T>
std::uint64_t hash_of_steps(const Scene& scene, int ranks, int cut_every) {
  DeviceSet devices = host_devices(ranks, {true, 0});
  Store<T> store(scene, devices);
  ImplicitStep<T> step(store);
  unsigned state = 11;
  for (int k = 0; k < steps; ++k) {
    if (cut_every > 0 && k % cut_every == 0) step.share_rows(any_cut(store.partition(), state));
    StepReport report;
    step.advance(scene.time.step, report);
    EXPECT_EQ(report.failure, Failure::none) << report.failure_detail;
  }
  return hash_state(store.model(), store.snapshot());
}

TEST(Rebalance, AnyCutAtAnyMoment) {
  for (const Scene& scene : {test::sheet_on_sphere(Precision::single_precision),
                             test::released_sheet(Precision::single_precision),
                             test::curled_sheet(Precision::single_precision, Bending::plate)}) {
    const std::uint64_t one = hash_of_steps<float>(scene, 1, 0);
    for (const int ranks : {2, 3, 5, 8})
      for (const int cut_every : {1, 7})
        EXPECT_EQ(one, hash_of_steps<float>(scene, ranks, cut_every))
            << ranks << " ranks, every " << cut_every;
  }
}

}  // namespace
}  // namespace weft
