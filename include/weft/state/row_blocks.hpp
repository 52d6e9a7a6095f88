#pragma once

#include <type_traits>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"

namespace weft {

/// A 3x3 block for each row, in slices of `slice` rows: component (i, j) of row r is at
/// ((r / slice) * 9 + 3 * i + j) * slice + r % slice. On CUDA the lanes of a warp have the rows of
/// a slice, so that each of its loads takes a whole line; on hosts the numbers of a block follow
/// each other.
/// @tparam Number T or const T
template <class Number>
struct RowBlocks {
  using T = std::remove_const_t<Number>;

  Index slice = 1;  ///< 1 on hosts, cuda_slice on CUDA
  Span<Number> value;

  /// Numbers of so many rows.
  static constexpr std::size_t size(Index rows, Index slice) noexcept {
    return 9 * static_cast<std::size_t>((rows + slice - 1) / slice) *
           static_cast<std::size_t>(slice);
  }

  WEFT_HD bool empty() const noexcept { return value.empty(); }
  /// The blocks from row `first` on, a multiple of the slice.
  RowBlocks from(Index first) const {
    const std::size_t place = 9 * static_cast<std::size_t>(first);
    return {slice, value.subspan(place, value.size() - place)};
  }

  WEFT_HD Mat3<T> load(Index row) const noexcept {
    return load(row, [](const Number* number) { return *number; });
  }
  /// @param read (const T*) loads a number
  template <class Read>
  WEFT_HD Mat3<T> load(Index row, const Read& read) const noexcept {
    const Number* from = first_of(row);
    Mat3<T> block;
    for (int k = 0; k < 9; ++k) block.e[k] = read(from + k * slice);
    return block;
  }
  WEFT_HD void store(Index row, const Mat3<T>& block) const noexcept {
    Number* to = first_of(row);
    for (int k = 0; k < 9; ++k) to[k * slice] = block.e[k];
  }

 private:
  WEFT_HD Number* first_of(Index row) const noexcept {
    return value.data() + Offset{row / slice * 9} * slice + row % slice;
  }
};

}  // namespace weft
