#pragma once

#include <cooperative_groups.h>

#include <cstddef>

#include "cuda/exec/sums.cuh"
#include "weft/elements/scalar.hpp"
#include "weft/kernels/respond/zone/team.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {

/// Threads of a block of the kernels that solve zones.
inline constexpr int zone_threads = 256;
inline constexpr int zone_warps = zone_threads / 32;

/// Sum over the `lanes` lanes of a warp that follow each other from a multiple of their number on.
template <Index lanes>
__device__ Vec3<double> sum_of_group(Vec3<double> value) {
  constexpr unsigned one_group = (1u << lanes) - 1;
  const unsigned group = one_group << (threadIdx.x % 32 / lanes * lanes);
  for (int step = 1; step < lanes; step *= 2)
    for (int c = 0; c < 3; ++c) value[c] += __shfl_xor_sync(group, value[c], step);
  return value;
}

/// The lanes of a warp.
struct WarpTeam {
  static constexpr bool alone = false;
  static constexpr bool in_order = true;
  static constexpr bool at_once = false;
  static constexpr Index lanes = 1;

  __device__ Index rank() const { return static_cast<Index>(threadIdx.x % 32); }
  __device__ static constexpr Index size() { return 32; }
  __device__ void sync() { __syncwarp(); }
  __device__ double sum(double value) {
    __syncwarp();
    return cuda::sum_lanes(value);
  }
  __device__ double largest(double value) {
    __syncwarp();
    for (int step = 1; step < 32; step *= 2)
      value = greater(value, __shfl_xor_sync(cuda::whole_warp, value, step));
    return value;
  }
  __device__ bool any(bool value) {
    __syncwarp();
    return __any_sync(cuda::whole_warp, value) != 0;
  }
  __device__ Index before(Index value, Index& total) {
    __syncwarp();
    const Index sum = cuda::sum_up_to_lane(value);
    total = __shfl_sync(cuda::whole_warp, sum, 31);
    return sum - value;
  }
  __device__ void sort(Offset* keys, Index count) { sort_bitonic(*this, keys, count); }
};

/// The threads of a block. What the warps come to goes through shared memory, by turns in one half
/// of it and the other, so that a warp may write its next part while another still reads the last.
class BlockTeam {
 public:
  static constexpr bool alone = false;
  static constexpr bool in_order = false;
  static constexpr bool at_once = false;
  static constexpr Index lanes = 8;

  /// @param parts [2 zone_warps] shared memory
  __device__ explicit BlockTeam(double* parts) : parts_(parts) {}
  __device__ Index rank() const { return static_cast<Index>(threadIdx.x); }
  __device__ static constexpr Index size() { return zone_threads; }
  __device__ void sync() { __syncthreads(); }
  __device__ double sum(double value) {
    const double* part = share(WarpTeam{}.sum(value));
    double sum = 0;
    for (int w = 0; w < zone_warps; ++w) sum += part[w];
    return sum;
  }
  __device__ double largest(double value) {
    const double* part = share(WarpTeam{}.largest(value));
    double largest = part[0];
    for (int w = 1; w < zone_warps; ++w) largest = greater(largest, part[w]);
    return largest;
  }
  __device__ bool any(bool value) { return __syncthreads_or(value ? 1 : 0) != 0; }
  __device__ Index before(Index value, Index& total) {
    Index of_warp;
    Index sum = WarpTeam{}.before(value, of_warp);
    const double* part = share(of_warp);  // a double holds every Index
    total = 0;
    for (int w = 0; w < zone_warps; ++w) {
      if (w < rank() / 32) sum += static_cast<Index>(part[w]);
      total += static_cast<Index>(part[w]);
    }
    return sum;
  }
  __device__ void sort(Offset* keys, Index count) { sort_bitonic(*this, keys, count); }
  __device__ Vec3<double> sum_of_lanes(Vec3<double> value) { return sum_of_group<lanes>(value); }

 private:
  /// @return [zone_warps] the warps' values
  __device__ const double* share(double of_warp) {
    double* part = parts_ + turn_ * zone_warps;
    turn_ = 1 - turn_;
    if (threadIdx.x % 32 == 0) part[threadIdx.x / 32] = of_warp;
    __syncthreads();
    return part;
  }

  double* parts_;
  int turn_ = 0;
};

/// The threads of all blocks of a cooperative launch. What the blocks come to goes through memory
/// of the GPU, by turns in one half of it and the other.
class GridTeam {
 public:
  static constexpr bool alone = false;
  static constexpr bool in_order = false;
  static constexpr bool at_once = true;
  static constexpr Index lanes = 8;

  /// @param parts     [2 zone_warps] shared memory
  /// @param of_blocks [2 blocks] memory of this launch alone
  __device__ GridTeam(double* parts, double* of_blocks) : block_(parts), of_blocks_(of_blocks) {}
  __device__ Index rank() const {
    return static_cast<Index>(blockIdx.x) * zone_threads + block_.rank();
  }
  __device__ Index size() const { return static_cast<Index>(gridDim.x) * zone_threads; }
  __device__ void sync() { cooperative_groups::this_grid().sync(); }
  __device__ double sum(double value) {
    const double* part = share(block_.sum(value));
    double sum = 0;
    for (unsigned b = threadIdx.x % 32; b < gridDim.x; b += 32) sum += __ldcg(part + b);
    return WarpTeam{}.sum(sum);
  }
  __device__ double largest(double value) {
    const double* part = share(block_.largest(value));
    double largest = __ldcg(part);
    for (unsigned b = threadIdx.x % 32; b < gridDim.x; b += 32)
      largest = greater(largest, __ldcg(part + b));
    return WarpTeam{}.largest(largest);
  }
  __device__ bool any(bool value) { return largest(value ? 1 : 0) > 0; }
  __device__ Index before(Index value, Index& total) {
    Index of_block;
    const Index inside = block_.before(value, of_block);
    const double* part = share(of_block);  // a double holds every Index
    double earlier = 0, all = 0;
    for (unsigned b = threadIdx.x % 32; b < gridDim.x; b += 32) {
      const double one = __ldcg(part + b);
      if (b < blockIdx.x) earlier += one;
      all += one;
    }
    total = static_cast<Index>(WarpTeam{}.sum(all));
    return static_cast<Index>(WarpTeam{}.sum(earlier)) + inside;
  }
  __device__ void sort(Offset* keys, Index count) { sort_bitonic(*this, keys, count); }
  __device__ Vec3<double> sum_of_lanes(Vec3<double> value) { return sum_of_group<lanes>(value); }

 private:
  /// @return [blocks] the blocks' values
  __device__ const double* share(double of_block) {
    double* part = of_blocks_ + turn_ * static_cast<int>(gridDim.x);
    turn_ = 1 - turn_;
    if (threadIdx.x == 0) part[blockIdx.x] = of_block;
    sync();
    return part;
  }

  BlockTeam block_;
  double* of_blocks_;
  int turn_ = 0;
};

template <class T>
__device__ Index collisions_of(const RespondZones<T>& a, Index zone) {
  return a.zone_begin.data()[zone + 1] - a.zone_begin.data()[zone];
}

template <class T>
__device__ std::byte* memory_of(const RespondZones<T>& a, Index zone) {
  const auto before = static_cast<std::size_t>(a.zone_begin.data()[zone]);
  return a.scratch.data() + zone_scratch_bytes(before, static_cast<std::size_t>(zone));
}

/// Submits the zones of more than zone_block_collisions, one after the other, each to all of the
/// GPU's processors.
template <class T>
void solve_largest_zones(Queue& queue, const RespondZones<T>& args);

}  // namespace weft
