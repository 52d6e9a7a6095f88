#include "host/implicit/parallel/transfer_overhead.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>

namespace weft {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pointwise;

/// Some products wait for their vector (the first after the own one), some do not.
const ProductTimes mixed{{2, 4, 4, 1}, {5, 1, 9}};

TEST(TransferOverhead, GatheredThenMultiplied) {
  EXPECT_THAT(gathered_times(mixed), ElementsAre(2, 11, 16, 26));
}

TEST(TransferOverhead, Pipelined) {
  // 5 + 4, then max(9, 6) + 4, then max(13, 15) + 1.
  EXPECT_THAT(pipelined_times(mixed), ElementsAre(2, 9, 13, 16));
}

/// If transfers are so fast that no product waits: the sums of the products' times.
/// @cite P-Cloth eq. (8)
std::vector<double> hidden_times(const ProductTimes& times) {
  std::vector<double> done(times.compute.size());
  std::partial_sum(times.compute.begin(), times.compute.end(), done.begin());
  return done;
}

/// If transfers are so slow that every product but the own one waits.
/// @cite P-Cloth eq. (9)
std::vector<double> exposed_times(const ProductTimes& times) {
  std::vector<double> done{times.compute.front()};
  for (std::size_t i = 1; i < times.compute.size(); ++i)
    done.push_back(std::accumulate(times.transfer.begin(),
                                   times.transfer.begin() + static_cast<std::ptrdiff_t>(i), 0.0) +
                   times.compute[i]);
  return done;
}

TEST(TransferOverhead, FastTransfersAreHidden) {
  const ProductTimes fast{{2, 4, 4, 1}, {1, 0.5, 2}};
  EXPECT_THAT(pipelined_times(fast), Pointwise(DoubleEq(), hidden_times(fast)));
}

TEST(TransferOverhead, LateTransfersGovern) {
  const ProductTimes slow{{2, 4, 4, 1}, {5, 6, 9}};
  EXPECT_THAT(pipelined_times(slow), Pointwise(DoubleEq(), exposed_times(slow)));
}

TEST(TransferOverhead, PipeliningLiesBetweenItsLimits) {
  for (int seed = 0; seed < 50; ++seed) {
    ProductTimes times;
    for (int i = 0; i < 8; ++i) {
      times.compute.push_back(1 + (7 * seed + 5 * i) % 11);
      if (i > 0) times.transfer.push_back((3 * seed + 13 * i) % 17);
    }
    const double pipelined = pipelined_times(times).back();
    EXPECT_LE(pipelined, gathered_times(times).back());
    EXPECT_GE(pipelined, std::max(hidden_times(times).back(), exposed_times(times).back()));
  }
}

TEST(TransferOverhead, OneRankHasNothingToWaitFor) {
  const ProductTimes alone{{3}, {}};
  for (const auto& of : {gathered_times, pipelined_times}) EXPECT_THAT(of(alone), ElementsAre(3));
  EXPECT_THAT(pipelined_times({}), IsEmpty());
}

}  // namespace
}  // namespace weft
