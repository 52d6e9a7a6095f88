#pragma once

#include <vector>

#include "weft/core/ids.hpp"
#include "weft/state/block_ell.hpp"

namespace weft {

/// Contiguous ranges of rows, one per rank.
struct Partition {
  Index partial_rows = 1024;     ///< rows per reduction block of a dot product
  Index slice = host_slice;      ///< rows per slice of the mesh matrix
  std::vector<Index> row_begin;  ///< [ranks + 1]; boundaries are multiples of partial_rows

  int ranks() const { return static_cast<int>(row_begin.size()) - 1; }
  Index row_count() const { return row_begin.back(); }
};

/// @param rows         number of rows, > 0
/// @param ranks        number of ranks, > 0; if there are more than reduction blocks, some have
///                     no rows
/// @param partial_rows a power of two, or 0: chosen from the number of rows alone
/// @param slice        rows per slice, which depend on the backend; changes no bits
Partition make_partition(Index rows, int ranks, Index partial_rows, Index slice = host_slice);

}  // namespace weft
