#include "host/implicit/parallel/work_cuts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace weft {
namespace {

/// What shares find where the number found up to a place in the table goes with `sum`.
std::vector<double> found(const WorkCuts& cuts, int ranks,
                          const std::function<double(double)>& sum) {
  std::vector<double> numbers;
  for (int r = 0; r < ranks; ++r) {
    const WorkShare share = cuts.share(r);
    numbers.push_back(sum(static_cast<double>(share.end) / whole_table) -
                      sum(static_cast<double>(share.begin) / whole_table));
  }
  return numbers;
}

double imbalance(const std::vector<double>& numbers) {
  return *std::max_element(numbers.begin(), numbers.end()) * static_cast<double>(numbers.size()) /
         std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

void expect_to_make_up_the_whole(const WorkCuts& cuts, int ranks) {
  EXPECT_EQ(cuts.share(0).begin, 0u);
  EXPECT_EQ(cuts.share(ranks - 1).end, whole_table);
  for (int r = 0; r < ranks; ++r) {
    EXPECT_LE(cuts.share(r).begin, cuts.share(r).end);
    if (r > 0) {
      EXPECT_EQ(cuts.share(r).begin, cuts.share(r - 1).end);
    }
  }
}

TEST(WorkCuts, BeginEven) {
  const WorkCuts cuts(4);
  expect_to_make_up_the_whole(cuts, 4);
  for (int r = 0; r < 4; ++r)
    EXPECT_EQ(cuts.share(r).begin, whole_table / 4 * static_cast<unsigned>(r));
}

// A tenth of the table comes to nine tenths of all.
TEST(WorkCuts, ComeToEvenNumbers) {
  const auto crowd = [](double place) {
    return 1000 * (0.1 * place + 0.9 * std::clamp((place - 0.33) / 0.1, 0.0, 1.0));
  };
  for (const int ranks : {2, 3, 5, 8}) {
    WorkCuts cuts(ranks);
    EXPECT_GT(imbalance(found(cuts, ranks, crowd)), 1.5);
    for (int k = 0; k < 10; ++k) {
      cuts.balance(found(cuts, ranks, crowd));
      expect_to_make_up_the_whole(cuts, ranks);
    }
    EXPECT_LT(imbalance(found(cuts, ranks, crowd)), 1.02) << ranks;
  }
}

TEST(WorkCuts, WhereNothingIsFoundAskingCounts) {
  for (const int ranks : {1, 2, 5}) {
    WorkCuts cuts(ranks);
    const WorkCuts even(ranks);
    cuts.balance(std::vector<double>(static_cast<std::size_t>(ranks), 0));
    for (int r = 0; r < ranks; ++r)
      EXPECT_NEAR(cuts.share(r).begin, even.share(r).begin, whole_table / 4096.0);
  }
}

// Everything at one place: no cut can part it, and none runs away.
TEST(WorkCuts, OnePlaceThatHasAll) {
  WorkCuts cuts(5);
  for (int k = 0; k < 50; ++k) {
    cuts.balance(found(cuts, 5, [](double place) { return place > 0.4 ? 1.0 : 0.0; }));
    expect_to_make_up_the_whole(cuts, 5);
  }
}

}  // namespace
}  // namespace weft
