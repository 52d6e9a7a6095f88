#pragma once

#include <utility>
#include <vector>

#include "weft/core/vec.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/exec/device.hpp"
#include "weft/state/sparse_inverse.hpp"

namespace weft {

/// The rows before each row that its factor has entries for: of those at most two edges away
/// within its domain, the nearest in material coordinates, ties by number. Rows are a rank's own.
/// @param neighbours [rows] rows that share a block of the mesh matrix, in any order
/// @param points     [rows] [m] material coordinates
/// @param domain     rows of a domain, see sparse_inverse_domain()
/// @return           [rows] at most sparse_inverse_width - 1 each, ascending
std::vector<std::vector<Index>> sparse_inverse_pattern(
    const std::vector<std::vector<Index>>& neighbours, const std::vector<Vec2<double>>& points,
    Index domain);

/// The neighbours that sparse_inverse_pattern() takes, from the pattern of a rank's mesh matrix.
/// @param slice_offset,column see BlockEll
/// @param begin               the rank's first row
std::vector<std::vector<Index>> mesh_neighbours(const std::vector<Offset>& slice_offset,
                                                const std::vector<Index>& column, Index slice,
                                                Index begin, Index rows);

/// Memory of a sparse factor.
class SparseInverseBuffers {
 public:
  /// @param pattern see sparse_inverse_pattern()
  void make(Device& device, const std::vector<std::vector<Index>>& pattern, Index slice);

  /// Whether there is one: after make().
  bool any() const { return factor_.any(); }
  /// Spans of this memory, valid until the next make().
  SparseInverse view() const { return factor_; }

 private:
  SparseInverse factor_;
  Buffer<SparseInverseEntry> lower_, upper_;
  Buffer<Offset> upper_offset_, place_;
};

}  // namespace weft
