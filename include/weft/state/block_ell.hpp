#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/state/row_order.hpp"

namespace weft {

/// Rows of a slice of the mesh matrix. Hosts: as many as a vector register holds floats. CUDA: as
/// many as a warp has threads, so that each of its loads takes a line that nothing else does.
constexpr Index host_slice = 8;
constexpr Index cuda_slice = 32;

/// Rows of a sparse matrix of 3x3 blocks in sliced ELLPACK form (block-ELL of P-Cloth section
/// 3.2.2, cut into slices of `slice` rows that are padded to their own longest row only).
/// The row at place p (see RowOrder) stands in slice p / slice, lane p % slice. Slice s owns the
/// slots slice_offset[s] to slice_offset[s + 1]; entry (slot, lane) has
///   column[slot * slice + lane]                   a global vertex, ascending along a row
///   value[(slot * 9 + 3 * i + j) * slice + lane]  component (i, j) of its block
/// Padding has zero values and repeats the row's own column, so that a product needs no branch.
/// Products of differences have no use for the blocks on the diagonal (docs/decisions/
/// 003-linear-solve.md), so those of the mesh stand apart, where only preconditioners read them.
template <class T>
struct BlockEll {
  Index row_count = 0;
  Index slice = 1;
  Span<const Offset> slice_offset;
  Span<const Index> column;
  Span<const T> value;
  Span<const Mat3<T>> diagonal{};  ///< [row_count] empty: in slots, as any other block
  RowOrder order{};
};

/// As BlockEll, to be written.
template <class T>
struct BlockEllOut {
  Index row_count = 0;
  Index slice = 1;
  Span<Offset> slice_offset;
  Span<Index> column;
  Span<T> value;
  Span<Mat3<T>> diagonal{};
  RowOrder order{};
};

/// As BlockEll with multiples of the identity for blocks: value[slot * slice + lane].
template <class T>
struct ScalarEll {
  Index row_count = 0;
  Index slice = 1;
  Span<const Offset> slice_offset;
  Span<const Index> column;
  Span<const T> value;
  RowOrder order{};  ///< of the mesh's matrix, which counts other entries
};

}  // namespace weft
