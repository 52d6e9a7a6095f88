#pragma once

#include <vector>

#include "weft/core/ids.hpp"

namespace weft {

/// Contiguous ranges of rows, one a rank.
struct Partition {
  Index partial_rows = 1024;     ///< rows of one partial sum of a dot product
  std::vector<Index> row_begin;  ///< [ranks + 1]; boundaries are multiples of partial_rows

  int ranks() const { return static_cast<int>(row_begin.size()) - 1; }
  Index row_count() const { return row_begin.back(); }
};

/// @param rows         number of rows, > 0
/// @param ranks        number of ranks, > 0; more ranks than partials leave some without rows
/// @param partial_rows a power of two, or 0: chosen from the number of rows alone
Partition make_partition(Index rows, int ranks, Index partial_rows);

}  // namespace weft
