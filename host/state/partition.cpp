#include "host/state/partition.hpp"

#include <algorithm>
#include <bit>

namespace weft {

Partition make_partition(Index rows, int ranks, Index partial_rows, Index slice) {
  Partition p;
  p.slice = slice;
  // Enough partials to share among ranks evenly, few enough to sum in no time.
  const auto sixteenth = static_cast<std::uint32_t>(std::max<Index>(rows / 16, 1));
  p.partial_rows = partial_rows > 0
                       ? partial_rows
                       : std::clamp<Index>(static_cast<Index>(std::bit_floor(sixteenth)), 8, 1024);
  const Offset partials = (Offset{rows} + p.partial_rows - 1) / p.partial_rows;
  for (int rank = 0; rank <= ranks; ++rank)
    p.row_begin.push_back(
        static_cast<Index>(std::min<Offset>(rows, partials * rank / ranks * p.partial_rows)));
  return p;
}

}  // namespace weft
