#pragma once

#include <cuda_runtime.h>

#include "cuda/exec/sums.cuh"
#include "weft/core/vec.hpp"
#include "weft/kernels/solve/pcg.hpp"

namespace weft::cuda {

/// a . b with a rounding that does not depend on what the compiler finds around it: kernels of
/// different transports have to agree to the bit.
__device__ inline double fused_dot(const Vec3<double>& a, const Vec3<double>& b) {
  return __fma_rn(a[2], b[2], __fma_rn(a[1], b[1], __dmul_rn(a[0], b[0])));
}

/// Adds one slot of a block matrix times `v - own` to `sum`; components stand `stride` apart.
/// Values are used once, so they are marked to leave the caches first: what stays there are the
/// vectors. Rounded as fused_dot() is, for the same reason.
template <class T>
__device__ void add_block(const T* value, std::size_t stride, const Vec3<T>& v, const Vec3<T>& own,
                          Vec3<T>& sum) {
  const Vec3<T> d = v - own;
#pragma unroll
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) sum[i] = fma(__ldcs(value + (3 * i + k) * stride), d[k], sum[i]);
}

/// A row's columns, `count` at a time and asked for one turn ahead: without that, each turn would
/// wait for the column indices first, and then for the vector entries at those columns.
template <int count>
class ColumnQueue {
 public:
  /// @param column first one   @param stride to the next   @param left how many there are
  __device__ ColumnQueue(const Index* column, Index stride, int left)
      : column_(column), stride_(stride), left_(left) {
    ask();
  }
  struct Columns {
    Index vertex[count];
    __device__ Index operator[](int k) const { return vertex[k]; }
  };
  /// The next ones; those beyond the last are undefined.
  __device__ Columns take() {
    const Columns columns = asked_;
    ask();
    return columns;
  }

 private:
  __device__ void ask() {
#pragma unroll
    for (int k = 0; k < count; ++k, column_ += stride_)
      if (k < left_) asked_.vertex[k] = __ldcs(column_);
    left_ -= count;
  }
  const Index* column_;
  Index stride_;
  int left_;
  Columns asked_;
};

/// Adds the row at a place of a block matrix of slices of `slice` rows, times v - own. One thread a
/// row: with slices of 32 rows each load of a warp takes a whole line, with 8 rows sectors of four
/// lines, and then the caches' tags limit it (benchmarks/journal/2026-11-one-h100.md).
template <int slice, class T>
__device__ void add_block_row(const BlockEll<T>& m, Index place, const Vec3<T>* v,
                              const Vec3<T>& own, Vec3<T>& sum) {
  const Index n = place / slice;
  const Offset begin = m.slice_offset.data()[n];
  const int slots =
      m.order.entries(place, static_cast<Index>(m.slice_offset.data()[n + 1] - begin));
  const Index* column = m.column.data() + begin * slice + place % slice;
  const T* value = m.value.data() + begin * 9 * slice + place % slice;
  ColumnQueue<3> next(column, slice, slots);
  for (int slot = 0; slot < slots; slot += 3) {
    const auto vertex = next.take();
#pragma unroll
    for (int k = 0; k < 3; ++k, value += 9 * slice)
      if (slot + k < slots) add_block(value, slice, v[vertex[k]], own, sum);
  }
}

/// The row at a place of a matrix of multiples of the identity, times v - own.
/// @param vertex of the row; the column of padding
template <int slice, class T>
__device__ Vec3<T> scalar_row(const ScalarEll<T>& m, Index place, Index vertex, const Vec3<T>* v,
                              const Vec3<T>& own) {
  const Index n = place / slice;
  const Offset begin = m.slice_offset.data()[n];
  const auto slots = static_cast<int>(m.slice_offset.data()[n + 1] - begin);
  const Index* column = m.column.data() + begin * slice + place % slice;
  const T* value = m.value.data() + begin * slice + place % slice;
  Vec3<T> sum{};
  ColumnQueue<4> next(column, slice, slots);
  for (int slot = 0; slot < slots; slot += 4) {
    const auto other = next.take();
#pragma unroll
    for (int k = 0; k < 4; ++k, value += slice)
      if (slot + k < slots && other[k] != vertex) sum += __ldcs(value) * (v[other[k]] - own);
  }
  return sum;
}

/// Block of a row, used once, as values of add_block() are.
template <class T>
__device__ Mat3<T> load_once(const RowBlocks<const T>& blocks, Index row) {
  return blocks.load(row, [](const T* number) { return __ldcs(number); });
}

/// Row `row` of the vertex part times its own velocity.
template <class T>
__device__ Vec3<T> vertex_row(const VertexPart<T>& vertex, Index row, const Vec3<T>& own) {
  Vec3<T> sum = __ldcs(vertex.mass.data() + row) * own;
  if (vertex.drag.empty()) return sum;
  const Mat3<T> drag = load_once(vertex.drag, row);
#pragma unroll
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) sum[i] = fma(drag(i, k), own[k], sum[i]);
  return sum;
}

/// Row `row` of the mesh's part of the system times v: what acts on the vertex alone, blocks, then
/// far entries, in stored order.
/// @param place of the row, see RowOrder   @param begin vertex of row 0
template <int slice, class T>
__device__ Vec3<T> mesh_row(const SolvePcgPart<T>& part, Index place, Index row, Index begin,
                            const Vec3<T>* v) {
  const Vec3<T> own = v[begin + row];
  Vec3<T> sum = vertex_row(part.vertex, row, own);
  add_block_row<slice>(part.mesh, place, v, own, sum);
  if (part.far.row_count > 0) sum += scalar_row<slice>(part.far, place, begin + row, v, own);
  return sum;
}

/// Adds row `row` of |A| |v| to `sum`, of any slices.
template <class T>
__device__ void add_magnitudes(const BlockEll<T>& m, Index row, const Vec3<T>* v, Vec3<T>& sum) {
  if (m.row_count == 0) return;
  const Index place = m.order.place(row), lane = place % m.slice;
  const Offset end = m.slice_offset.data()[place / m.slice + 1];
  for (Offset slot = m.slice_offset.data()[place / m.slice]; slot < end; ++slot) {
    const Vec3<T>& x = v[m.column.data()[slot * m.slice + lane]];
    const T* value = m.value.data() + slot * 9 * m.slice + lane;
    for (int k = 0; k < 9; ++k) sum[k / 3] += abs(value[k * m.slice] * x[k % 3]);
  }
}
template <class T>
__device__ void add_magnitudes(const Mat3<T>& block, const Vec3<T>& v, Vec3<T>& sum) {
  for (int k = 0; k < 9; ++k) sum[k / 3] += abs(block.e[k] * v[k % 3]);
}
template <class T>
__device__ void add_magnitudes(const ScalarEll<T>& m, Index row, const Vec3<T>* v, Vec3<T>& sum) {
  if (m.row_count == 0) return;
  const Index place = m.order.place(row), lane = place % m.slice;
  const Offset end = m.slice_offset.data()[place / m.slice + 1];
  for (Offset slot = m.slice_offset.data()[place / m.slice]; slot < end; ++slot)
    for (int c = 0; c < 3; ++c)
      sum[c] +=
          abs(m.value.data()[slot * m.slice + lane] * v[m.column.data()[slot * m.slice + lane]][c]);
}

/// Of links as they are multiplied: link by link.
template <class T>
__device__ void add_magnitudes(const ContactOperator<T>& links, Index row, const Vec3<T>* v,
                               Vec3<T>& sum) {
  visit_contact_entries(links, row,
                        [&](Index column, T weight, const ContactOperatorEntry<T>& link) {
                          const Vec3<T>& x = v[column];
                          for (int k = 0; k < 9; ++k)
                            sum[k / 3] += abs(weight * link.component(k) * x[k % 3]);
                        });
}

/// Square of row `row` of |A| |x| + |b|.
/// @param own x at the row's vertex
template <class T>
__device__ double magnitude_sq(const SolvePcgPart<T>& part, Index row, const Vec3<T>& own) {
  Vec3<T> sum = part.rhs.data()[row];
  for (int c = 0; c < 3; ++c) sum[c] = abs(sum[c]);
  add_magnitudes(part.mesh.diagonal.data()[row], own, sum);
  add_magnitudes(part.mesh, row, part.x.data(), sum);
  add_magnitudes(part.far, row, part.x.data(), sum);
  add_magnitudes(part.contact, row, part.x.data(), sum);
  return fused_dot(vec_cast<double>(sum), vec_cast<double>(sum));
}

}  // namespace weft::cuda
