#pragma once

#include <cuda_runtime.h>

namespace weft::cuda {

inline constexpr unsigned whole_warp = 0xffffffffu;

/// Sum over groups of `width` lanes that follow each other, a power of two; every lane gets its
/// group's. The order depends on `width` alone.
template <class T>
__device__ T sum_lanes(T value, int width = 32) {
  for (int step = 1; step < width; step *= 2) value += __shfl_xor_sync(whole_warp, value, step);
  return value;
}

}  // namespace weft::cuda
