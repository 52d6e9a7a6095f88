#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"

namespace weft {

constexpr int grid_levels = 31;
/// Cells that a box stands in at most.
constexpr int cells_a_box = 8;
/// Size of a cell in mean extents of boxes. Twice: most boxes then stand on one level and in few
/// cells; measured 15 % faster in a drape than once.
constexpr float cell_extents = 2;

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
  Span<const float> mean_extent;     ///< [1] [m] of these boxes
  Span<const float> asking_extent;   ///< [1] [m] of most of those that will ask
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

/// @param cell_inv [1/m] 0: everything is in one cell
WEFT_HD inline std::int32_t cell_coordinate(float x, float cell_inv) noexcept {
  using std::floor;
  if (cell_inv == 0.0f) return 0;
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

/// Size of a cell on level 0. [m]
WEFT_HD inline float level_0_cell(const CollideGrid& a) noexcept {
  float most = a.mean_extent.data()[0];
  if (most < a.asking_extent.data()[0]) most = a.asking_extent.data()[0];
  return cell_extents * (most < 1e-30f ? 1e-30f : most);
}

/// Where a box stands in the table.
struct GridPlace {
  std::uint32_t bucket;
  std::uint32_t tag;
};

/// The cells that a box stands in, all of one level.
struct PlacesOf {
  CellRange cells;
  int level;
  int count;  ///< of cells; none for a box whose upper ends are no numbers

  /// @param n below count
  WEFT_HD GridPlace operator()(int n, std::uint32_t buckets) const noexcept {
    const std::int32_t across = cells.hi[0] - cells.lo[0] + 1;
    const std::int32_t up = cells.hi[1] - cells.lo[1] + 1;
    const std::int32_t x = cells.lo[0] + n % across;
    const std::int32_t y = cells.lo[1] + n / across % up;
    const std::int32_t z = cells.lo[2] + n / (across * up);
    return {cell_bucket(x, y, z, level, buckets), cell_tag(x, y, z, level)};
  }
};

/// @param cell [m] size of a cell on level 0
WEFT_HD inline PlacesOf places_of(const Box& box, float cell) noexcept {
  PlacesOf places;
  places.level = level_of(box, cell);
  places.cells = cells_of(box, cell_inverse(cell, places.level));
  places.count = 1;
  for (int c = 0; c < 3; ++c) {
    const std::int32_t cells = places.cells.hi[c] - places.cells.lo[c] + 1;
    places.count *= cells > 0 ? cells : 0;
  }
  return places;
}

/// Number of the lowest bit that is set; some is.
WEFT_HD inline int lowest_bit(std::uint32_t bits) noexcept {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  return std::countr_zero(bits);
#endif
}

/// Cells of one level that a query has to look into.
WEFT_HD inline double cell_count(const CellRange& r) noexcept {
  double count = 1;
  for (int c = 0; c < 3; ++c)
    count *= static_cast<double>(r.hi[c]) - static_cast<double>(r.lo[c]) + 1;
  return count;
}

/// Whether a box covers as many cells as there are boxes in the grid, or more: it is then compared
/// with all of them, so that no query is dearer than that.
WEFT_HD inline bool covers_too_many(const Grid& grid, std::size_t boxes, const Box& box) noexcept {
  double cells = 0;
  for (std::uint32_t levels = grid.levels.data()[0]; levels != 0; levels &= levels - 1)
    cells += cell_count(cells_of(box, cell_inverse(grid.cell.data()[0], lowest_bit(levels))));
  return !(cells < static_cast<double>(boxes));
}

void run(OnHost, Queue& queue, const CollideGrid& args);
void run(OnCuda, Queue& queue, const CollideGrid& args);

}  // namespace weft
