#pragma once

#include <cstdint>

#include "weft/kernels/collide/grid.hpp"

namespace weft {

/// Calls visit(bucket, tag) for every `stride`-th cell, from number `first` on, of those that `box`
/// covers on each level in use.
/// @pre !covers_too_many(grid, boxes, box)
template <class Visit>
__device__ void for_each_cell(const Grid& grid, const Box& box, int first, int stride,
                              Visit visit) {
  const auto buckets = static_cast<std::uint32_t>(grid.bucket_offset.size() - 1);
  const float cell = grid.cell.data()[0];
  for (std::uint32_t levels = grid.levels.data()[0]; levels != 0; levels &= levels - 1) {
    const int level = lowest_bit(levels);
    const CellRange r = cells_of(box, cell_inverse(cell, level));
    const std::int32_t across = r.hi[0] - r.lo[0] + 1;
    const std::int32_t up = r.hi[1] - r.lo[1] + 1;
    const std::int32_t deep = r.hi[2] - r.lo[2] + 1;
    if (across <= 0 || up <= 0 || deep <= 0) continue;  // a box that is no box
    const std::int32_t count = across * up * deep;
    for (std::int32_t n = first; n < count; n += stride) {
      const std::int32_t x = r.lo[0] + n % across;
      const std::int32_t y = r.lo[1] + n / across % up;
      const std::int32_t z = r.lo[2] + n / (across * up);
      visit(cell_bucket(x, y, z, level, buckets), cell_tag(x, y, z, level));
    }
  }
}

}  // namespace weft
