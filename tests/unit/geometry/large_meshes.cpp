// Numbers of meshes of tens of millions of triangles: products of them come near 2^31 or beyond.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <limits>
#include <vector>

#include "host/implicit/parallel/work_cuts.hpp"
#include "host/state/partition.hpp"
#include "weft/core/ids.hpp"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {
namespace {

constexpr Index most = std::numeric_limits<Index>::max();

TEST(LargeMeshes, PartitionsReachTheLastRow) {
  for (const Index rows : {Index{8'003'241}, Index{85'899'345}, Index{most - 1}, most})
    for (const int ranks : {1, 2, 3, 8, 64}) {
      const Partition p = make_partition(rows, ranks, 0);
      ASSERT_EQ(p.row_begin.size(), static_cast<std::size_t>(ranks) + 1);
      EXPECT_EQ(p.row_begin.front(), 0);
      EXPECT_EQ(p.row_count(), rows);
      const Offset even = Offset{rows} / ranks;
      for (int r = 0; r < ranks; ++r) {
        const auto n = static_cast<std::size_t>(r);
        const Offset own = Offset{p.row_begin[n + 1]} - p.row_begin[n];
        EXPECT_LE(std::abs(own - even), p.partial_rows) << rows << " rows, " << ranks << " ranks";
        if (r > 0) {
          EXPECT_EQ(p.row_begin[n] % p.partial_rows, 0);
        }
      }
    }
}

TEST(LargeMeshes, WorkBeyond32BitsIsSharedEvenly) {
  // 1,000 groups of 2^40 box tests each.
  constexpr Offset each = Offset{1} << 40;
  constexpr Index groups = 1000;
  std::vector<Offset> sums;
  for (Index g = 0; g <= groups; ++g) sums.push_back(g * each);
  const Span<const Offset> work(sums.data(), sums.size());
  for (const int ranks : {1, 2, 3, 8}) {
    const WorkCuts cuts(ranks);
    EXPECT_EQ(share_begin(work, cuts.share(0).begin), 0);
    EXPECT_EQ(share_begin(work, cuts.share(ranks - 1).end), groups);
    for (int r = 0; r < ranks; ++r) {
      const WorkShare share = cuts.share(r);
      const Index own = share_begin(work, share.end) - share_begin(work, share.begin);
      EXPECT_NEAR(own, static_cast<double>(groups) / ranks, 1) << ranks;
    }
  }
}

// What validate() allows: the gather table of hinges numbers a corner's column as 4 (4 h + i) + j
// and its complement, and a triangle has one and a half hinges.
TEST(LargeMeshes, CodesOfCornersFit) {
  constexpr std::int64_t triangles = most / 25;
  static_assert(16 * (3 * triangles / 2) + 15 <= most);
  static_assert(9 * triangles + 8 <= most);
  // 16 million, by a grid of 2828 x 2828 cells.
  static_assert(2 * std::int64_t{2828} * 2828 < triangles);
}

}  // namespace
}  // namespace weft
