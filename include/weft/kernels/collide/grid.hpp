#pragma once

#include <cmath>
#include <cstdint>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"

namespace weft {

constexpr int grid_levels = 31;

/// A box stored in a cell. The tag tells the cells of one box apart that share a bucket. The box
/// stands here as well, so that a cell is read in one go.
struct GridEntry {
  std::uint32_t tag;
  Index number;
  Box box;
};

/// Spatial hash of boxes (P-Cloth sections 4.2, 4.4) with cells of several sizes: a box stands on
/// the lowest level on which it is in at most two cells along each axis, hence in at most eight, so
/// that a floor of two triangles costs no more than a button. The highest level is one cell.
struct Grid {
  Span<const GridEntry> entries;
  Span<const Index> bucket_offset;   ///< [buckets + 1]
  Span<const std::uint32_t> levels;  ///< [1] bit l set: level l is in use
  Span<const float> cell;            ///< [1] [m] size of a cell on level 0
};

/// Builds a Grid over boxes by count, scan and write.
/// Reads: boxes, mean extents, wanted. Writes: the rest. Order: by bucket, then by box. Flags:
/// none; the caller provides eight entries a box, which is all that there can be.
struct CollideGrid {
  Span<const Box> boxes;
  Span<const float> mean_extent;     ///< [2] of these boxes, and of those that will ask
  Span<const unsigned char> wanted;  ///< [1] 0: the grid stands as it is; empty: 1
  Span<GridEntry> entries;           ///< [8 count]
  Span<Index> bucket_offset;         ///< [buckets + 1], buckets a power of two
  Span<std::uint32_t> levels;        ///< [1]
  Span<float> cell;                  ///< [1]
};

/// Cells that a box covers on one level.
struct CellRange {
  std::int32_t lo[3];
  std::int32_t hi[3];
};

WEFT_HD inline std::int32_t cell_coordinate(float x, float cell_inv) noexcept {
  using std::floor;
  const float c = floor(x * cell_inv);
  // Far outside or not finite: everything there shares the outermost cells.
  if (!(c > -1e9f)) return -1000000000;
  if (c > 1e9f) return 1000000000;
  return static_cast<std::int32_t>(c);
}

/// One over the size of a cell of a level. [1/m] On the highest level everything is in one cell.
WEFT_HD inline float cell_inverse(float cell, int level) noexcept {
  using std::ldexp;
  return level + 1 < grid_levels ? 1.0f / ldexp(cell, level) : 0.0f;
}

WEFT_HD inline CellRange cells_of(const Box& box, float cell_inv) noexcept {
  CellRange r;
  for (int c = 0; c < 3; ++c) {
    r.lo[c] = cell_coordinate(box.lo[c], cell_inv);
    r.hi[c] = cell_coordinate(box.hi[c], cell_inv);
  }
  return r;
}

/// Lowest level on which the box is in at most two cells along each axis, rounding included, and
/// not larger than a cell.
WEFT_HD inline int level_of(const Box& box, float cell) noexcept {
  float extent = 0;
  for (int c = 0; c < 3; ++c) {
    const float e = box.hi[c] - box.lo[c];
    if (e > extent) extent = e;
  }
  int level = 0;
  while (level + 1 < grid_levels && extent > cell) {
    cell *= 2;
    ++level;
  }
  for (; level + 1 < grid_levels; cell *= 2, ++level) {
    const CellRange r = cells_of(box, 1.0f / cell);
    if (r.hi[0] - r.lo[0] <= 1 && r.hi[1] - r.lo[1] <= 1 && r.hi[2] - r.lo[2] <= 1) break;
  }
  return level;
}

/// Neighbouring cells of a level always differ in their tags.
WEFT_HD inline std::uint32_t cell_tag(std::int32_t x, std::int32_t y, std::int32_t z,
                                      int level) noexcept {
  return (static_cast<std::uint32_t>(x) & 511u) | (static_cast<std::uint32_t>(y) & 511u) << 9 |
         (static_cast<std::uint32_t>(z) & 511u) << 18 | static_cast<std::uint32_t>(level) << 27;
}

/// Teschner et al. 2003, "Optimized spatial hashing", with the level mixed in.
WEFT_HD inline std::uint32_t cell_bucket(std::int32_t x, std::int32_t y, std::int32_t z, int level,
                                         std::uint32_t buckets) noexcept {
  std::uint32_t h =
      static_cast<std::uint32_t>(x) * 73856093u ^ static_cast<std::uint32_t>(y) * 19349663u ^
      static_cast<std::uint32_t>(z) * 83492791u ^ static_cast<std::uint32_t>(level) * 2654435761u;
  h ^= h >> 15;
  return h & (buckets - 1u);
}

void run(OnHost, Queue& queue, const CollideGrid& args);

}  // namespace weft
