#pragma once

#include "cuda/exec/sums.cuh"
#include "weft/state/sparse_inverse.hpp"

namespace weft::cuda {

/// Byte k of a word, less sparse_inverse_zero. Conversions have a sixteenth of the throughput of
/// this: the byte becomes the lowest of the number 2^23, whose next one is 1 more.
template <int k>
__device__ float byte_of(unsigned word) {
  return __uint_as_float(__byte_perm(word, 0x4b000000u, 0x7440 + k)) -
         (8388608.0F + sparse_inverse_zero);
}

/// Adds an entry, as its four words, times x to `sum`.
template <class T>
__device__ void add_entry(const uint4& e, const Vec3<T>& x, Vec3<T>& sum) {
  const T scale = __uint_as_float(e.w & 0xffff0000u);
  sum[0] += scale * (byte_of<0>(e.y) * x[0] + byte_of<1>(e.y) * x[1] + byte_of<2>(e.y) * x[2]);
  sum[1] += scale * (byte_of<3>(e.y) * x[0] + byte_of<0>(e.z) * x[1] + byte_of<1>(e.z) * x[2]);
  sum[2] += scale * (byte_of<2>(e.z) * x[0] + byte_of<3>(e.z) * x[1] + byte_of<0>(e.w) * x[2]);
}

/// `slots` entries, `stride` apart, times x, whose first number is that of row `first`. Used once,
/// so marked to leave the caches first.
template <class T>
__device__ Vec3<T> sparse_inverse_entries(const SparseInverseEntry* entry, Index stride, int slots,
                                          const Vec3<T>* x, Index first) {
  constexpr int count = 4;
  const auto* words = reinterpret_cast<const uint4*>(entry);
  Vec3<T> sum{};
#pragma unroll 1
  for (int slot = 0; slot < slots; slot += count) {
    uint4 e[count];
#pragma unroll
    for (int k = 0; k < count; ++k) e[k] = __ldcs(words + min(slot + k, slots - 1) * stride);
#pragma unroll
    for (int k = 0; k < count; ++k)
      if (slot + k < slots) add_entry(e[k], x[static_cast<Index>(e[k].x) - first], sum);
  }
  return sum;
}

/// Row `row` of the factor times r, and of its transpose times y, both from row `first` on.
template <class T>
__device__ Vec3<T> times_lower(const SparseInverse& f, Index row, const Vec3<T>* r, Index first) {
  return sparse_inverse_entries(f.lower.data() + f.lower_place(row, 0), f.slice,
                                sparse_inverse_width, r, first);
}
template <class T>
__device__ Vec3<T> times_upper(const SparseInverse& f, Index row, const Vec3<T>* y, Index first) {
  const Index n = row / f.slice;
  const Offset begin = f.upper_offset.data()[n];
  return sparse_inverse_entries(f.upper.data() + begin * f.slice + row % f.slice, f.slice,
                                static_cast<int>(f.upper_offset.data()[n + 1] - begin), y, first);
}

}  // namespace weft::cuda
