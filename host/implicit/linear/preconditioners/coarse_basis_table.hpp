#pragma once

#include <vector>

#include "weft/core/vec.hpp"
#include "weft/state/coarse_basis.hpp"

namespace weft {

/// Frames of the preconditioner's aggregates, see CoarseBasisLevels. A function of the vertex order
/// and of partial_rows alone.
struct CoarseBasisTable {
  Index partial_rows = 0, unit_rows = 0;
  std::vector<CoarseBasisPoint> point;        ///< [cloth vertices]
  std::vector<CoarseBasisStep<double>> unit;  ///< [units] to the aggregates of partial sums
  std::vector<Index> aggregates;              ///< [levels] of partial_rows * 16^level rows
  /// [levels but the last][aggregates] to the next level
  std::vector<std::vector<CoarseBasisStep<double>>> larger;
};

/// @param points       [cloth vertices] [m] material coordinates, in vertex order
/// @param partial_rows a power of two, at most pcg_partial_rows_max
CoarseBasisTable make_coarse_basis_table(const std::vector<Vec2<double>>& points,
                                         Index partial_rows);

}  // namespace weft
