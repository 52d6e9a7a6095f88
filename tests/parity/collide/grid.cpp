#include "weft/kernels/collide/grid.hpp"
#include "host/exec/host_devices.hpp"

#include <algorithm>
#include <map>

#include "tests/parity/collide/scene.hpp"

namespace weft::parity {
namespace {

constexpr std::size_t buckets = 1024;

/// Boxes of all sizes, in some of which many others lie; number 5 is no box.
std::vector<Box> boxes_of_all_sizes() {
  Random random(33);
  std::vector<Box> all;
  for (int n = 0; n < 900; ++n) {
    const float size = std::ldexp(0.004f, n % 50 == 0 ? 14 : n % 7);
    Box box;
    for (int c = 0; c < 3; ++c) {
      box.lo[c] = random.uniform<float>(-1, 1);
      box.hi[c] = box.lo[c] + random.uniform<float>(0, 1) * size;
    }
    all.push_back(box);
  }
  all[5].lo[1] = all[5].hi[1] = std::nanf("");
  return all;
}

/// All in one cell.
std::vector<Box> boxes_in_a_heap() {
  std::vector<Box> all(700, Box{{0.1f, 0.1f, 0.1f}, {0.2f, 0.2f, 0.2f}});
  return all;
}

std::vector<Box> boxes_of(int which) {
  if (which == 0) return boxes_of_all_sizes();
  return which == 1 ? boxes_in_a_heap() : std::vector<Box>();
}

class CollideGridParity : public testing::TestWithParam<int> {
 protected:
  std::vector<Box> boxes_ = boxes_of(GetParam());

  /// Twice: the second time over other boxes, which are not wanted.
  Outputs build(Device& device) const {
    GridBuffers grid(device, boxes_, {0.05f, 0.02f}, buckets);
    grid.run();
    Outputs all = grid.outputs();
    grid.boxes = upload(device, std::vector<Box>(boxes_.size(), Box{{9, 9, 9}, {9, 9, 9}}));
    grid.wanted = upload(device, std::vector<unsigned char>{0});
    grid.run();
    expect_same_bits(grid.outputs(), all);
    return all;
  }
};

/// Every box stands where a query of any point of it looks, and in ascending order.
TEST_P(CollideGridParity, HostPutsEveryBoxInItsCells) {
  const DeviceSet devices = host_devices(1, {.poison = true});
  GridBuffers grid(devices[0], boxes_, {0.05f, 0.02f}, buckets);
  grid.run();
  const std::vector<GridEntry> entries = download(grid.entries);
  const std::vector<Index> offset = download(grid.bucket_offset);
  const std::uint32_t levels = download(grid.levels).front();
  const float cell = download(grid.cell).front();
  EXPECT_EQ(cell, 2 * 0.05f);
  std::map<Index, Index> stored;
  for (std::size_t b = 0; b < buckets; ++b)
    for (auto e = static_cast<std::size_t>(offset[b]); e < static_cast<std::size_t>(offset[b + 1]);
         ++e) {
      ++stored[entries[e].number];
      if (e == static_cast<std::size_t>(offset[b])) continue;
      EXPECT_LE(entries[e - 1].number, entries[e].number);
    }
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (boxes_[i].lo[1] != boxes_[i].lo[1]) continue;
    EXPECT_LE(stored[static_cast<Index>(i)], cells_a_box);
    const float* ends[2] = {boxes_[i].lo, boxes_[i].hi};
    for (int corner = 0; corner < 8; ++corner) {
      bool found = false;
      for (int level = 0; level < grid_levels; ++level) {
        if ((levels >> level & 1u) == 0) continue;
        std::int32_t at[3];
        for (int c = 0; c < 3; ++c)
          at[c] = cell_coordinate(ends[corner >> c & 1][c], cell_inverse(cell, level));
        const auto b = cell_bucket(at[0], at[1], at[2], level, buckets);
        for (auto e = static_cast<std::size_t>(offset[b]);
             e < static_cast<std::size_t>(offset[b + 1]); ++e)
          found |= entries[e].number == static_cast<Index>(i) &&
                   entries[e].tag == cell_tag(at[0], at[1], at[2], level);
      }
      ASSERT_TRUE(found) << "box " << i << ", corner " << corner;
    }
  }
}

TEST_P(CollideGridParity, CudaGivesTheHostsTable) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const DeviceSet host = host_devices(1);
  expect_same_bits(build((*cuda)[0]), build(host[0]));
}

INSTANTIATE_TEST_SUITE_P(AllSizesHeapAndNothing, CollideGridParity, testing::Values(0, 1, 2));

}  // namespace
}  // namespace weft::parity
