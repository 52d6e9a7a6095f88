#pragma once

#include <cuda_runtime.h>

namespace weft::cuda {

/// Mask of all lanes of a warp.
inline constexpr unsigned whole_warp = 0xffffffffu;

/// Sum over groups of `width` lanes that follow each other, a power of two; every lane gets its
/// group's. The order depends on `width` alone.
template <class T>
__device__ T sum_lanes(T value, int width = 32) {
  for (int step = 1; step < width; step *= 2) value += __shfl_xor_sync(whole_warp, value, step);
  return value;
}

/// Sum over the lanes of a warp up to this one.
template <class T>
__device__ T sum_up_to_lane(T value) {
  for (int step = 1; step < 32; step *= 2) {
    const T left = __shfl_up_sync(whole_warp, value, step);
    if (static_cast<int>(threadIdx.x % 32) >= step) value += left;
  }
  return value;
}

/// Sum over the threads of the block before this one, and over all of them in `total`.
/// @param warp_sum [threads / 32] shared memory, free again after the next __syncthreads()
template <int threads, class T>
__device__ T sum_before(T value, T* warp_sum, T& total) {
  const int warp = static_cast<int>(threadIdx.x) / 32;
  const T sum = sum_up_to_lane(value);
  __syncthreads();
  if (threadIdx.x % 32 == 31) warp_sum[warp] = sum;
  __syncthreads();
  T before = 0;
  total = 0;
  for (int w = 0; w < threads / 32; ++w) {
    if (w < warp) before += warp_sum[w];
    total += warp_sum[w];
  }
  return before + sum - value;
}

}  // namespace weft::cuda
