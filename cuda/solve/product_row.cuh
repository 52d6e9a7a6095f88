#pragma once

#include <cuda_runtime.h>

#include "weft/core/vec.hpp"
#include "weft/kernels/solve/pcg.hpp"

namespace weft::cuda {

/// Adds one slot of a block matrix times `v` to `sum`; components stand `stride` apart. Values are
/// used once, so they are marked to leave the caches first: what stays there are the vectors.
template <class T>
__device__ void add_block(const T* value, std::size_t stride, const Vec3<T>& v, Vec3<T>& sum) {
#pragma unroll
  for (int i = 0; i < 3; ++i)
    sum[i] += __ldcs(value + (3 * i) * stride) * v[0] +
              __ldcs(value + (3 * i + 1) * stride) * v[1] +
              __ldcs(value + (3 * i + 2) * stride) * v[2];
}

/// Row `row` of a block matrix of slices of `slice` rows, times v. One thread a row: with slices of
/// 32 rows each load of a warp takes a whole line, with 8 rows sectors of four lines, and then the
/// caches' tags limit it (benchmarks/results/1x-nvidia-h100/notes.md).
template <int slice, class T>
__device__ Vec3<T> block_row(const BlockEll<T>& m, Index row, const Vec3<T>* v) {
  const Index n = row / slice;
  const Offset begin = m.slice_offset.data()[n];
  const auto slots = static_cast<int>(m.slice_offset.data()[n + 1] - begin);
  const Index* column = m.column.data() + begin * slice + row % slice;
  const T* value = m.value.data() + begin * 9 * slice + row % slice;
  Vec3<T> sum{};
#pragma unroll 2
  for (int slot = 0; slot < slots; ++slot, column += slice, value += 9 * slice)
    add_block(value, slice, v[__ldcs(column)], sum);
  return sum;
}

/// The same for slices of any size, as the contact part has.
template <class T>
__device__ Vec3<T> block_row(const BlockEll<T>& m, Index row, const Vec3<T>* v) {
  const Index n = row / m.slice;
  const Index lane = row % m.slice;
  const auto stride = static_cast<std::size_t>(m.slice);
  const Offset end = m.slice_offset.data()[n + 1];
  Vec3<T> sum{};
  for (Offset slot = m.slice_offset.data()[n]; slot < end; ++slot)
    add_block(m.value.data() + slot * 9 * m.slice + lane, stride,
              v[m.column.data()[slot * m.slice + lane]], sum);
  return sum;
}

/// Row `row` of a matrix of multiples of the identity, times v.
template <int slice, class T>
__device__ Vec3<T> scalar_row(const ScalarEll<T>& m, Index row, const Vec3<T>* v) {
  const Index n = row / slice;
  const Offset begin = m.slice_offset.data()[n];
  const auto slots = static_cast<int>(m.slice_offset.data()[n + 1] - begin);
  const Index* column = m.column.data() + begin * slice + row % slice;
  const T* value = m.value.data() + begin * slice + row % slice;
  Vec3<T> sum{};
#pragma unroll 4
  for (int slot = 0; slot < slots; ++slot, column += slice, value += slice)
    sum += __ldcs(value) * v[__ldcs(column)];
  return sum;
}

/// Row `row` of the whole system times v: mesh, far and contact entries, in stored order.
template <int slice, class T>
__device__ Vec3<T> system_row(const SolvePcgPart<T>& part, Index row, const Vec3<T>* v) {
  Vec3<T> sum = block_row<slice>(part.mesh, row, v);
  if (part.far.row_count > 0) sum += scalar_row<slice>(part.far, row, v);
  if (part.contact.row_count > 0) sum += block_row(part.contact, row, v);
  return sum;
}
}  // namespace weft::cuda
