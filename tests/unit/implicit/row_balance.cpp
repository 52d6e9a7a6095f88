#include "host/implicit/parallel/row_balance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace weft {
namespace {

using Work = RowBalance::Work;

double busiest(const Work& work, const std::vector<std::size_t>& begin) {
  double most = 0;
  for (std::size_t r = 0; r + 1 < begin.size(); ++r)
    most = std::max(most,
                    std::accumulate(work.begin() + static_cast<std::ptrdiff_t>(begin[r]),
                                    work.begin() + static_cast<std::ptrdiff_t>(begin[r + 1]), 0.0));
  return most;
}

/// Least that the busiest of `ranks` can have of the partials from `first` on, tried out.
double least(const Work& work, std::size_t first, int ranks) {
  double sum = std::accumulate(work.begin() + static_cast<std::ptrdiff_t>(first), work.end(), 0.0);
  if (ranks == 1) return sum;
  double best = sum;
  double own = 0;
  for (std::size_t end = first; end < work.size(); ++end) {
    own += work[end];
    best = std::min(best, std::max(own, least(work, end + 1, ranks - 1)));
  }
  return best;
}

TEST(RowBalance, RangesAreTheBestThereAre) {
  Work work;
  unsigned state = 7;
  for (int p = 0; p < 14; ++p) {
    state = state * 1664525u + 1013904223u;
    work.push_back(1 + state / 65536u % 90);
    for (const int ranks : {1, 2, 3, 5}) {
      const auto begin = even_ranges(work, ranks);
      ASSERT_EQ(begin.size(), static_cast<std::size_t>(ranks) + 1);
      EXPECT_EQ(begin.front(), 0u);
      EXPECT_EQ(begin.back(), work.size());
      EXPECT_TRUE(std::is_sorted(begin.begin(), begin.end()));
      EXPECT_DOUBLE_EQ(busiest(work, begin), least(work, 0, ranks)) << p << ", " << ranks;
    }
  }
}

TEST(RowBalance, RanksWithoutPartialsGetNone) {
  EXPECT_EQ(even_ranges({3, 1}, 4), (std::vector<std::size_t>{0, 1, 2, 2, 2}));
}

/// Eight partials of 16 rows, the last of 5; two ranks.
Partition eight_partials() {
  Partition p;
  p.partial_rows = 16;
  p.row_begin = {0, 64, 117};
  return p;
}
const Work crowded{1, 1, 1, 1, 1, 1, 5, 5};

TEST(RowBalance, WaitsUntilAsMuchIsLostAsItTakes) {
  RowBalance balance(Rebalance::when_it_pays, Backend::host);
  int solves = 0;
  // Each iteration loses half of an even share: 12 of one rank where both have 8.
  for (; !balance.due(); ++solves) balance.add({4, 12}, 10);
  EXPECT_EQ(solves, 5);  // 50 iterations
  RowBalance gpus(Rebalance::when_it_pays, Backend::cuda);
  for (int k = 0; k < 499; ++k) gpus.add({4, 12}, 20);
  EXPECT_FALSE(gpus.due());
  gpus.add({4, 12}, 20);
  EXPECT_TRUE(gpus.due());
}

TEST(RowBalance, CutsByWork) {
  RowBalance balance(Rebalance::when_it_pays, Backend::host);
  balance.add({4, 12}, 1000);
  const auto cut = balance.cut(crowded, eight_partials());
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->row_begin, (std::vector<Index>{0, 96, 117}));
  EXPECT_DOUBLE_EQ(cut->imbalance_before, 1.5);
  EXPECT_DOUBLE_EQ(cut->imbalance_after, 1.25);
  EXPECT_FALSE(balance.due());
}

TEST(RowBalance, KeepsWhatNoCutMakesBetter) {
  RowBalance balance(Rebalance::when_it_pays, Backend::host);
  Partition p = eight_partials();
  p.row_begin = {0, 96, 117};
  balance.add({6, 10}, 1000);
  EXPECT_TRUE(balance.due());
  EXPECT_FALSE(balance.cut(crowded, p));
  // What cannot be avoided is no loss.
  balance.add({6, 10}, 1000000);
  EXPECT_FALSE(balance.due());
  // Once it gets worse than that, it is.
  balance.add({2, 14}, 1000);
  EXPECT_TRUE(balance.due());
}

TEST(RowBalance, NeverAndAlways) {
  RowBalance never(Rebalance::never, Backend::host);
  never.add({4, 12}, 1000000);
  EXPECT_FALSE(never.due());
  RowBalance always(Rebalance::every_step, Backend::host);
  EXPECT_FALSE(always.due());  // nothing has been counted yet
  always.add({8, 8.01}, 1);
  EXPECT_TRUE(always.due());
  EXPECT_TRUE(always.cut(crowded, eight_partials()));
}

}  // namespace
}  // namespace weft
