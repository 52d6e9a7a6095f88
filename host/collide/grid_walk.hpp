#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/grid.hpp"

namespace weft {

/// Cells of one level that a query has to look into.
inline double cell_count(const CellRange& r) {
  double count = 1;
  for (int c = 0; c < 3; ++c)
    count *= static_cast<double>(r.hi[c]) - static_cast<double>(r.lo[c]) + 1;
  return count;
}

/// Calls visit(number) once for each box of the grid that meets `box` and has a number of at least
/// `lowest`. A pair of boxes may share several cells; it counts in the one that holds the lower
/// corner of their intersection. A box that covers more cells than there are boxes is compared with
/// all of them instead, so that a query is never dearer than that.
/// @param hulls the boxes that the grid was built over
template <class Visit>
void for_each_meeting(const Grid& grid, Span<const Box> hulls, const Box& box, Index lowest,
                      Visit visit) {
  if (hulls.empty()) return;
  const auto buckets = static_cast<std::uint32_t>(grid.bucket_offset.size() - 1);
  const std::uint32_t levels = grid.levels[0];
  double cells = 0;
  for (int level = 0; level < grid_levels; ++level)
    if ((levels >> level & 1u) != 0)
      cells += cell_count(cells_of(box, cell_inverse(grid.cell[0], level)));
  if (!(cells < static_cast<double>(hulls.size()))) {
    for (auto i = static_cast<std::size_t>(lowest); i < hulls.size(); ++i)
      if (boxes_meet(box, hulls.data()[i])) visit(static_cast<Index>(i));
    return;
  }
  for (int level = 0; level < grid_levels; ++level) {
    if ((levels >> level & 1u) == 0) continue;
    const float inv = cell_inverse(grid.cell[0], level);
    const CellRange r = cells_of(box, inv);
    for (std::int32_t z = r.lo[2]; z <= r.hi[2]; ++z)
      for (std::int32_t y = r.lo[1]; y <= r.hi[1]; ++y)
        for (std::int32_t x = r.lo[0]; x <= r.hi[0]; ++x) {
          const std::uint32_t bucket = cell_bucket(x, y, z, level, buckets);
          const std::uint32_t tag = cell_tag(x, y, z, level);
          const Index begin = grid.bucket_offset.data()[bucket];
          for (Index e = grid.bucket_offset.data()[bucket + 1] - 1; e >= begin; --e) {
            const GridEntry& entry = grid.entries.data()[e];
            if (entry.number < lowest) break;  // a bucket lists its boxes in ascending order
            const Box& other = entry.box;
            if ((static_cast<int>(entry.tag == tag) & static_cast<int>(boxes_meet(box, other))) ==
                0)
              continue;
            if (cell_coordinate(std::max(box.lo[0], other.lo[0]), inv) != x ||
                cell_coordinate(std::max(box.lo[1], other.lo[1]), inv) != y ||
                cell_coordinate(std::max(box.lo[2], other.lo[2]), inv) != z)
              continue;
            visit(entry.number);
          }
        }
  }
}

}  // namespace weft
