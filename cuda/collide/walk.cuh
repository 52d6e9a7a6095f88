#pragma once

#include <cstdint>

#include "cuda/exec/sums.cuh"
#include "weft/kernels/collide/grid.hpp"

namespace weft {

/// The last lane whose `first` is at or before `n`; lane 0 has 0 and none less than the one before.
__device__ inline int lane_that_has(std::int32_t first, std::int32_t n) {
  int lane = 0;
  for (int step = 16; step > 0; step /= 2)
    if (__shfl_sync(cuda::whole_warp, first, lane + step) <= n) lane += step;
  return lane;
}

/// The cells that a box covers on the levels in use, numbered through all of them. All lanes of a
/// warp call everything together: each keeps what belongs to the level of its number.
class CoveredCells {
 public:
  struct Cell {
    bool is_one;  ///< false: there are fewer
    std::uint32_t bucket, tag;
  };

  __device__ CoveredCells(const Grid& grid, const Box& box)
      : buckets_(static_cast<std::uint32_t>(grid.bucket_offset.size() - 1)) {
    static_assert(grid_levels <= 32);
    const auto level = static_cast<int>(threadIdx.x % 32);
    double cells = 0;
    std::int32_t count = 0;
    if ((grid.levels.data()[0] >> level & 1u) != 0) {
      const CellRange r = cells_of(box, cell_inverse(grid.cell.data()[0], level));
      for (int c = 0; c < 3; ++c) lo_[c] = r.lo[c];
      across_ = r.hi[0] - r.lo[0] + 1;
      up_ = r.hi[1] - r.lo[1] + 1;
      cells = cell_count(r);
      const bool is_box = across_ > 0 && up_ > 0 && r.hi[2] >= r.lo[2];
      if (is_box && cells < count_max) count = static_cast<std::int32_t>(cells);
    }
    cells_ = cuda::sum_lanes(cells);
    const std::int32_t sum = cuda::sum_up_to_lane(count);
    first_ = sum - count;
    count_ = __shfl_sync(cuda::whole_warp, sum, 31);
  }

  /// See covers_too_many(), for all lanes.
  /// @param boxes_a_cell boxes that are compared while a cell is looked up
  __device__ bool too_many(std::size_t boxes, double boxes_a_cell = 1) const {
    return !(boxes_a_cell * cells_ < static_cast<double>(boxes));
  }

  /// How many there are. @pre !too_many()
  __device__ std::int32_t count() const { return count_; }
  /// Number n of them, which also differs from lane to lane.
  __device__ Cell operator()(std::int32_t n) const {
    const int level = lane_that_has(first_, n);
    const bool is_one = n < count_;
    n -= __shfl_sync(cuda::whole_warp, first_, level);
    // Divisors are positive where there is such a cell.
    const std::int32_t across = max(1, __shfl_sync(cuda::whole_warp, across_, level));
    const std::int32_t up = max(1, __shfl_sync(cuda::whole_warp, up_, level));
    const std::int32_t x = __shfl_sync(cuda::whole_warp, lo_[0], level) + n % across;
    const std::int32_t y = __shfl_sync(cuda::whole_warp, lo_[1], level) + n / across % up;
    const std::int32_t z = __shfl_sync(cuda::whole_warp, lo_[2], level) + n / across / up;
    return {is_one, cell_bucket(x, y, z, level, buckets_), cell_tag(x, y, z, level)};
  }

 private:
  /// Far more than there are boxes.
  static constexpr double count_max = 1 << 30;

  std::uint32_t buckets_;
  std::int32_t lo_[3] = {};
  std::int32_t across_ = 1, up_ = 1;
  std::int32_t first_;  ///< cells of the levels before
  std::int32_t count_;
  double cells_;
};

}  // namespace weft
