// Shares of time: the formulas of Liang & Lin 2018, section 4, and Algorithm 1.
#include "host/time_parallel/schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace weft::test {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Costs of a coarse run of one a step and a fine one of `ratio`, times a factor by step.
template <class Factor>
ScheduleCosts costs_of(std::int64_t steps, double ratio, Factor factor) {
  ScheduleCosts costs{{0}, {0}, 0};
  for (std::int64_t n = 1; n <= steps; ++n) {
    costs.coarse.push_back(static_cast<double>(n));
    costs.fine.push_back(costs.fine.back() + ratio * factor(n));
  }
  return costs;
}

ScheduleCosts even_costs(std::int64_t steps, double ratio) {
  return costs_of(steps, ratio, [](std::int64_t) { return 1.0; });
}

void expect_valid(const std::vector<std::int64_t>& starts, std::int64_t steps, int slices) {
  ASSERT_EQ(starts.size(), static_cast<std::size_t>(slices));
  EXPECT_EQ(starts.front(), 0);
  EXPECT_TRUE(std::adjacent_find(starts.begin(), starts.end(), std::greater_equal<>()) ==
              starts.end());
  EXPECT_LT(starts.back(), steps);
}

TEST(Partition, SpeedupsAreThoseOfThePaper) {
  EXPECT_NEAR(uniform_speedup(100, 64), 39.26, 0.005);
  EXPECT_NEAR(balanced_speedup(100, 64), 47.44, 0.005);
  EXPECT_NEAR(least_speedup(100, 64), 39.02, 0.005);
  // eq. (6): for large K it is p - p (p - 1) / 2 K
  EXPECT_NEAR(balanced_speedup(1e6, 64), 64 - 64 * 63 / 2e6, 1e-4);
  EXPECT_LT(balanced_speedup(100, 100000), 100 + 1e-9);
}

TEST(Partition, BoundsAreInOrder) {
  for (const double ratio : {2.0, 10.0, 100.0, 1323.0})
    for (const int slices : {1, 2, 16, 128, 512}) {
      EXPECT_LT(least_speedup(ratio, slices), uniform_speedup(ratio, slices));
      EXPECT_LE(uniform_speedup(ratio, slices), balanced_speedup(ratio, slices) * (1 + 1e-12));
      EXPECT_LE(balanced_speedup(ratio, slices), ratio);
    }
}

TEST(Partition, RecoveryCostsEverySlice) {
  // 10,000 steps in 100 slices are 100 steps each; 25 more make that 125.
  EXPECT_NEAR(speedup_with_recovery(10000, 25, 100), 80, 1e-9);
  EXPECT_DOUBLE_EQ(speedup_with_recovery(10000, 0, 47), 47);
}

TEST(Partition, UniformSlicesHaveOneLength) {
  EXPECT_EQ(uniform_starts(10, 4), (std::vector<std::int64_t>{0, 2, 5, 7}));
  EXPECT_EQ(uniform_starts(3, 3), (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(balanced_starts(10, 4, infinite), uniform_starts(10, 4));
}

TEST(Partition, BalancedSlicesEndTogether) {
  const std::int64_t steps = 1000000;
  const auto starts = balanced_starts(steps, 64, 100);
  expect_valid(starts, steps, 64);
  EXPECT_EQ(starts[1], static_cast<std::int64_t>(std::floor(0.01 / (1 - std::pow(0.99, 64)) *
                                                            static_cast<double>(steps))));
  double first = 0, last = 1e300;
  for (std::size_t j = 0; j < 64; ++j) {
    const std::int64_t next = j + 1 < 64 ? starts[j + 1] : steps;
    const double end = static_cast<double>(starts[j] + 100 * (next - starts[j]));
    first = std::max(first, end);
    last = std::min(last, end);
  }
  EXPECT_NEAR(first, last, 250) << "by the floors alone";
}

TEST(Partition, EachSliceHasAStep) {
  expect_valid(balanced_starts(8, 8, 1.5), 8, 8);
  expect_valid(balanced_starts(20, 16, 2), 20, 16);
  expect_valid(adaptive_starts(even_costs(12, 3), 12), 12, 12);
}

TEST(Partition, CutOfTheFirstSlice) {
  // Nothing known: slices of one length.
  EXPECT_DOUBLE_EQ(adaptive_cut(1000, 4, infinite), 250);
  EXPECT_DOUBLE_EQ(adaptive_cut(1000, 1, 7), 1000);
  // With the ratio known the cut is where the balanced slices of eq. (5) have it.
  const double share = (1 - 0.99) / (1 - std::pow(0.99, 64));
  EXPECT_NEAR(adaptive_cut(1000, 64, 100), 1000 * share, 1e-9);
}

TEST(Partition, AdaptiveIsBalancedWhereCostsAreEven) {
  const std::int64_t steps = 20000;
  const ScheduleCosts costs = even_costs(steps, 100);
  const auto starts = adaptive_starts(costs, 64);
  expect_valid(starts, steps, 64);
  const double serial = costs.fine.back();
  const double speedup = serial / schedule_length(costs, starts);
  EXPECT_GE(speedup, uniform_speedup(100, 64));
  EXPECT_LE(speedup, balanced_speedup(100, 64) * (1 + 1e-9));
  EXPECT_GE(speedup, 0.97 * balanced_speedup(100, 64));
  EXPECT_NEAR(serial / schedule_length(costs, balanced_starts(steps, 64, 100)),
              balanced_speedup(100, 64), 0.2);
  EXPECT_NEAR(serial / schedule_length(costs, uniform_starts(steps, 64)), uniform_speedup(100, 64),
              0.3);
}

TEST(Partition, AdaptiveFollowsCostsThatChange) {
  // Free fall for a tenth of the run, then contact that comes and goes.
  const std::int64_t steps = 10000;
  const ScheduleCosts costs = costs_of(steps, 60, [&](std::int64_t n) {
    return n < steps / 10 ? 0.5 : n / 50 % 2 == 0 ? 0.8 : 1.2;
  });
  const double adaptive = schedule_length(costs, adaptive_starts(costs, 32));
  EXPECT_LT(1.05 * adaptive, schedule_length(costs, uniform_starts(steps, 32)));
}

/// Asks for a cut with the work of all slices so far.
bool decide(AdaptiveCuts& cuts, const std::vector<std::vector<double>>& work) {
  return cuts.decide([&](int slice, double wanted) {
    return SliceDone::within(work[static_cast<std::size_t>(slice)], wanted);
  });
}

TEST(Partition, CutsKnowNothingBeyondTheirTime) {
  // Work that a slice has done ahead of its time changes no cut.
  AdaptiveCuts cuts(1000, 4);
  AdaptiveCuts ahead(1000, 4);
  cuts.set_delay(3);
  ahead.set_delay(3);
  std::vector<std::vector<double>> work{{0}};
  for (std::int64_t n = 10; n <= 1000 && !cuts.complete(); n += 10) {
    cuts.advance_coarse(n, static_cast<double>(n));
    ahead.advance_coarse(n, static_cast<double>(n));
    for (std::size_t j = 0; j < work.size(); ++j)
      while (work[j].back() <= cuts.work_wanted(static_cast<int>(j)))
        work[j].push_back(work[j].back() + 5);
    std::vector<std::vector<double>> more = work;
    for (auto& slice : more)
      for (int i = 0; i < 20; ++i) slice.push_back(slice.back() + 50);
    const bool cut = decide(cuts, work);
    EXPECT_EQ(decide(ahead, more), cut);
    if (cut) work.push_back({30});  // its recovery
  }
  expect_valid(cuts.starts(), 1000, 4);
  EXPECT_EQ(cuts.starts(), ahead.starts());
  EXPECT_NE(cuts.starts(), uniform_starts(1000, 4)) << "a ratio of 5 was counted";
}

TEST(Partition, AFewStepsTellNoRatio) {
  // The run takes a while to begin to move: its first 20 steps cost half of the others. One slice
  // has 31 steps, in which the coarse run does less than one of them.
  const ScheduleCosts costs =
      costs_of(4000, 48, [](std::int64_t n) { return n <= 20 ? 0.5 : 1.0; });
  const double uniform = schedule_length(costs, uniform_starts(4000, 128));
  EXPECT_LT(1.1 * schedule_length(costs, adaptive_starts(costs, 128)), uniform);
  for (const int slices : {8, 16, 32, 64})
    EXPECT_LT(schedule_length(costs, adaptive_starts(costs, slices)),
              1.001 * schedule_length(costs, uniform_starts(4000, slices)))
        << slices;
}

TEST(Partition, AFewDearStepsOfTheCoarseRunTellNoRatio) {
  // Every fortieth step of the coarse run takes twenty times as long as the others.
  ScheduleCosts costs{{0}, {0}, 75};
  for (std::int64_t n = 0; n < 4000; ++n) {
    costs.coarse.push_back(costs.coarse.back() + (n % 4 > 0 ? 0 : n % 160 == 0 ? 80 : 4));
    costs.fine.push_back(costs.fine.back() + 25);
  }
  for (const int slices : {16, 64, 128})
    EXPECT_LT(schedule_length(costs, adaptive_starts(costs, slices)),
              1.3 * schedule_length(costs, uniform_starts(4000, slices)))
        << slices;
}

TEST(Partition, AWhileInWhichTheCoarseRunJamsIsNotWhatIsToCome) {
  // For a twentieth of the run coarse steps cost what fine ones do, and elsewhere 3 % of that.
  for (const double share : {0.0, 0.1, 0.5}) {
    ScheduleCosts costs{{0}, {0}, 3};
    for (std::int64_t n = 0; n < 10000; ++n) {
      const double at = static_cast<double>(n) / 10000;
      const double coarse = at >= share && at < share + 0.05 ? 10 : 0.3;
      costs.coarse.push_back(costs.coarse.back() + (n % 10 > 0 ? 0 : coarse));
      costs.fine.push_back(costs.fine.back() + 1);
    }
    for (const int slices : {16, 64, 128})
      EXPECT_LT(schedule_length(costs, adaptive_starts(costs, slices)),
                1.05 * schedule_length(costs, uniform_starts(10000, slices)))
          << share << ' ' << slices;
  }
}

TEST(Partition, WhatASliceHasDoneByATime) {
  const std::vector<double> work{3, 5, 9};
  const auto steps = [&](double most) { return SliceDone::within(work, most).steps; };
  EXPECT_EQ(steps(2), 0);
  EXPECT_EQ(SliceDone::within(work, 2).work, 0) << "its recovery is not over";
  EXPECT_EQ(steps(3), 0);
  EXPECT_EQ(steps(8.9), 1);
  EXPECT_EQ(SliceDone::within(work, 8.9).work, 5);
  EXPECT_EQ(steps(infinite), 2);
}

TEST(Partition, ScheduleHasTheLastSliceAfterTheCoarseRun) {
  // Two slices of 10 steps: coarse 1 a step, fine 4, recovery 7.
  ScheduleCosts costs = even_costs(20, 4);
  costs.recovery = 7;
  EXPECT_DOUBLE_EQ(schedule_length(costs, {0, 10}), 10 + 7 + 40);
  EXPECT_DOUBLE_EQ(schedule_length(costs, {0}), 80);
}

}  // namespace
}  // namespace weft::test
