#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"

namespace weft {

/// The order of a matrix's rows on CUDA, and the number of entries of each. Every two slices are
/// sorted together, rows with more entries first. Neighbouring lanes then stop at similar slots,
/// and padding is not loaded. Hosts keep rows in their own order, as sorting saves no time there
/// (benchmarks/journal/2026-11-one-h200.md).
struct RowOrder {
  static constexpr Index window = 64;  ///< rows of two slices

  /// [rows] see pack(); empty: row r is at place r
  Span<const Index> packed;

  /// Larger numbers of entries are stored as this one.
  static constexpr Index entries_max = (Index{1} << 18) - 1;

  /// Element p of `packed`: the row at place p, the place of row p, and the number of entries of
  /// the row at place p.
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
  /// @param slots of the slice; the result for rows with entries_max or more
  WEFT_HD Index entries(Index place, Index slots) const noexcept {
    if (packed.empty()) return slots;
    const Index counted = at(place) / (window * window);
    return counted < entries_max ? counted : slots;
  }

 private:
  WEFT_HD Index at(Index place) const noexcept { return packed[static_cast<std::size_t>(place)]; }
};

}  // namespace weft
