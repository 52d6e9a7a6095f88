#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/grid.hpp"

namespace weft {

/// Calls visit(x, y, z, level, bucket) for each cell that `box` covers on levels in use.
template <class Visit>
void for_each_cell(const Grid& grid, const Box& box, Visit visit) {
  const auto buckets = static_cast<std::uint32_t>(grid.bucket_offset.size() - 1);
  for (std::uint32_t levels = grid.levels[0]; levels != 0; levels &= levels - 1) {
    const int level = std::countr_zero(levels);
    const CellRange r = cells_of(box, cell_inverse(grid.cell[0], level));
    for (std::int32_t z = r.lo[2]; z <= r.hi[2]; ++z)
      for (std::int32_t y = r.lo[1]; y <= r.hi[1]; ++y)
        for (std::int32_t x = r.lo[0]; x <= r.hi[0]; ++x)
          visit(x, y, z, level, cell_bucket(x, y, z, level, buckets));
  }
}

/// Number of box tests that a query of `box` takes: entries of its cells with a number of at least
/// `lowest`.
/// @param boxes that the grid was built over
inline Offset query_tests(const Grid& grid, std::size_t boxes, const Box& box, Index lowest) {
  if (covers_too_many(grid, boxes, box)) return static_cast<Offset>(boxes) - lowest;
  Offset count = 0;
  for_each_cell(grid, box, [&](std::int32_t, std::int32_t, std::int32_t, int, std::uint32_t b) {
    const GridEntry* begin = grid.entries.data() + grid.bucket_offset.data()[b];
    const GridEntry* end = grid.entries.data() + grid.bucket_offset.data()[b + 1];
    if (lowest > 0)
      begin = std::partition_point(begin, end,
                                   [lowest](const GridEntry& e) { return e.number < lowest; });
    count += end - begin;
  });
  return count;
}

/// Calls visit(number) once for each box of the grid that meets `box` and has a number of at least
/// `lowest`. A pair of boxes may share several cells; it counts in the one that holds the lower
/// corner of their intersection.
/// @param hulls the boxes that the grid was built over
template <class Visit>
void for_each_meeting(const Grid& grid, Span<const Box> hulls, const Box& box, Index lowest,
                      Visit visit) {
  if (covers_too_many(grid, hulls.size(), box)) {
    for (auto i = static_cast<std::size_t>(lowest); i < hulls.size(); ++i)
      if (boxes_meet(box, hulls.data()[i])) visit(static_cast<Index>(i));
    return;
  }
  for_each_cell(
      grid, box,
      [&](std::int32_t x, std::int32_t y, std::int32_t z, int level, std::uint32_t bucket) {
        const float inv = cell_inverse(grid.cell[0], level);
        const std::uint32_t tag = cell_tag(x, y, z, level);
        const Index begin = grid.bucket_offset.data()[bucket];
        for (Index e = grid.bucket_offset.data()[bucket + 1] - 1; e >= begin; --e) {
          const GridEntry& entry = grid.entries.data()[e];
          if (entry.number < lowest) break;  // a bucket lists its boxes in ascending order
          const Box& other = entry.box;
          if ((static_cast<int>(entry.tag == tag) & static_cast<int>(boxes_meet(box, other))) == 0)
            continue;
          if (cell_coordinate(std::max(box.lo[0], other.lo[0]), inv) == x &&
              cell_coordinate(std::max(box.lo[1], other.lo[1]), inv) == y &&
              cell_coordinate(std::max(box.lo[2], other.lo[2]), inv) == z)
            visit(entry.number);
        }
      });
}

}  // namespace weft
