#include "host/base/buckets.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace weft {
namespace {

TEST(Buckets, KeepTheOrderOfItemsOfOneKey) {
  const std::vector<Index> keys{2, 0, 2, -1, 3, 0, 2};
  Buckets b = buckets_by(7, 5, [&](Index i) { return keys[static_cast<std::size_t>(i)]; });
  EXPECT_EQ(b.offset, (std::vector<Index>{0, 2, 2, 5, 6, 6}));
  EXPECT_EQ(b.item, (std::vector<Index>{1, 5, 0, 2, 6, 4}));
  EXPECT_EQ(std::vector<Index>(b.begin(2), b.end(2)), (std::vector<Index>{0, 2, 6}));
  EXPECT_EQ(b.begin(1), b.end(1));
}

TEST(Buckets, OfNothing) {
  const Buckets b = buckets_by(0, 0, [](Index) { return 0; });
  EXPECT_EQ(b.offset, std::vector<Index>{0});
  EXPECT_TRUE(b.item.empty());
}

}  // namespace
}  // namespace weft
