#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"

namespace weft {

/// Which row stands in which place of a matrix on CUDA, and how many entries it has. Of the rows of
/// two slices those with many entries come first: lanes beside each other then end together, and
/// what pads the others is not loaded. (On hosts, slices of such rows have less padding, but take
/// no less time.)
struct RowOrder {
  static constexpr Index window = 64;  ///< rows of two slices

  /// [rows] see pack(); empty: row r stands in place r
  Span<const Index> packed;

  /// Entries of a row at most, as pack() counts them.
  static constexpr Index entries_max = (Index{1} << 18) - 1;

  /// What is known at place p: the row there, the place of row p, and the entries of the row there.
  static constexpr Index pack(Index row, Index place, Index entries) noexcept {
    const Index counted = entries < entries_max ? entries : entries_max;
    return (counted * window + place % window) * window + row % window;
  }
  WEFT_HD Index row(Index place) const noexcept {
    return packed.empty() ? place : place / window * window + at(place) % window;
  }
  WEFT_HD Index place(Index row) const noexcept {
    return packed.empty() ? row : row / window * window + at(row) / window % window;
  }
  /// @param slots of the slice, which rows with entries_max or more have
  WEFT_HD Index entries(Index place, Index slots) const noexcept {
    if (packed.empty()) return slots;
    const Index counted = at(place) / (window * window);
    return counted < entries_max ? counted : slots;
  }

 private:
  WEFT_HD Index at(Index place) const noexcept { return packed[static_cast<std::size_t>(place)]; }
};

}  // namespace weft
