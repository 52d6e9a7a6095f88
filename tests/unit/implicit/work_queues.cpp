#include "host/implicit/parallel/work_queues.hpp"

#include <gtest/gtest.h>

#include <set>
#include <utility>

namespace weft {
namespace {

using Queue = std::vector<std::pair<int, int>>;

Queue pairs(const std::vector<Transfer>& queue) {
  Queue all;
  for (const Transfer& t : queue) all.emplace_back(t.from, t.vector);
  return all;
}

/// P-Cloth figure 4: rank 0 gets v1 from 1, v2 from 2, v3 from 1.
TEST(WorkQueues, FourRanksAsInThePaper) {
  const auto queues = work_queues(4);
  ASSERT_EQ(queues.size(), 4u);
  EXPECT_EQ(pairs(queues[0]), (Queue{{1, 1}, {2, 2}, {1, 3}}));
  EXPECT_EQ(pairs(queues[1]), (Queue{{0, 0}, {3, 3}, {0, 2}}));
  EXPECT_EQ(pairs(queues[2]), (Queue{{3, 3}, {0, 0}, {3, 1}}));
  EXPECT_EQ(pairs(queues[3]), (Queue{{2, 2}, {1, 1}, {2, 0}}));
}

TEST(WorkQueues, EightRanksGoDownAgainWithTheOtherHalfsVectors) {
  EXPECT_EQ(pairs(work_queues(8)[5]),
            (Queue{{4, 4}, {7, 7}, {4, 6}, {1, 1}, {4, 0}, {7, 3}, {4, 2}}));
}

/// Rank 3 is not there: nobody gets its vector, and rank 2 gets vector 1 from its owner.
TEST(WorkQueues, ThreeRanksDoWithoutTheFourth) {
  const auto queues = work_queues(3);
  ASSERT_EQ(queues.size(), 3u);
  EXPECT_EQ(pairs(queues[0]), (Queue{{1, 1}, {2, 2}, {-1, -1}}));
  EXPECT_EQ(pairs(queues[1]), (Queue{{0, 0}, {-1, -1}, {0, 2}}));
  EXPECT_EQ(pairs(queues[2]), (Queue{{-1, -1}, {0, 0}, {1, 1}}));
}

TEST(WorkQueues, OneRankNeedsNothing) {
  EXPECT_TRUE(work_queues(1).front().empty());
  EXPECT_EQ(arrival_stages({}, 0, 1), (std::vector<unsigned char>{0}));
}

class WorkQueuesOf : public testing::TestWithParam<int> {
 protected:
  int ranks_ = GetParam();
  std::vector<std::vector<Transfer>> queues_ = work_queues(ranks_);
  const Transfer& at(int rank, std::size_t stage) const {
    return queues_[static_cast<std::size_t>(rank)][stage];
  }
};

TEST_P(WorkQueuesOf, EveryRankReceivesEveryOtherVectorOnce) {
  ASSERT_EQ(queues_.size(), static_cast<std::size_t>(ranks_));
  for (int r = 0; r < ranks_; ++r) {
    EXPECT_EQ(queues_[static_cast<std::size_t>(r)].size(), queues_[0].size());
    std::multiset<int> received{r}, all;
    for (int v = 0; v < ranks_; ++v) all.insert(v);
    for (std::size_t n = 0; n < queues_[0].size(); ++n)
      if (at(r, n).any()) {
        EXPECT_NE(at(r, n).from, r);
        received.insert(at(r, n).vector);
      }
    EXPECT_EQ(received, all) << "rank " << r;
  }
}

TEST_P(WorkQueuesOf, NobodySendsWhatItDoesNotHaveYet) {
  std::vector<std::set<int>> has(static_cast<std::size_t>(ranks_));
  for (int r = 0; r < ranks_; ++r) has[static_cast<std::size_t>(r)] = {r};
  for (std::size_t n = 0; n < queues_[0].size(); ++n) {
    const auto before = has;
    for (int r = 0; r < ranks_; ++r) {
      const Transfer& t = at(r, n);
      if (!t.any()) continue;
      ASSERT_LT(t.from, ranks_);
      EXPECT_EQ(before[static_cast<std::size_t>(t.from)].count(t.vector), 1u)
          << "stage " << n << ", rank " << r;
      has[static_cast<std::size_t>(r)].insert(t.vector);
    }
  }
}

TEST_P(WorkQueuesOf, EveryStageHasSomethingToDo) {
  for (std::size_t n = 0; n < queues_[0].size(); ++n) {
    bool any = false;
    for (int r = 0; r < ranks_; ++r) any = any || at(r, n).any();
    EXPECT_TRUE(any) << "stage " << n;
  }
}

TEST_P(WorkQueuesOf, ArrivalsAreTheStagesOfTheQueue) {
  for (int r = 0; r < ranks_; ++r) {
    const auto& queue = queues_[static_cast<std::size_t>(r)];
    const std::vector<unsigned char> stages = arrival_stages(queue, r, ranks_);
    ASSERT_EQ(stages.size(), static_cast<std::size_t>(ranks_));
    for (int v = 0; v < ranks_; ++v) {
      const auto stage = static_cast<std::size_t>(stages[static_cast<std::size_t>(v)]);
      if (v == r)
        EXPECT_EQ(stage, 0u);
      else
        EXPECT_EQ(at(r, stage - 1).vector, v);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Ranks, WorkQueuesOf, testing::Values(2, 3, 4, 5, 6, 7, 8, 13, 64));

class WorkQueuesOfPowers : public WorkQueuesOf {};

/// Every vector is wanted on the other side of the root switch, and goes over it once: with n
/// vectors, half of them each way, all in one stage, between counterparts.
TEST_P(WorkQueuesOfPowers, EveryVectorCrossesTheRootSwitchOnce) {
  const int half = ranks_ / 2;
  std::vector<int> crossings(static_cast<std::size_t>(ranks_));
  for (std::size_t n = 0; n < queues_[0].size(); ++n)
    for (int r = 0; r < ranks_; ++r) {
      const Transfer& t = at(r, n);
      if ((t.from < half) == (r < half)) continue;
      ++crossings[static_cast<std::size_t>(t.vector)];
      EXPECT_EQ(n, static_cast<std::size_t>(half - 1));
      EXPECT_EQ(t.vector, (r + half) % ranks_);
    }
  for (int v = 0; v < ranks_; ++v) EXPECT_EQ(crossings[static_cast<std::size_t>(v)], 1) << v;
}

INSTANTIATE_TEST_SUITE_P(Ranks, WorkQueuesOfPowers, testing::Values(2, 4, 8, 64));

}  // namespace
}  // namespace weft
