#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Weighted sums over vertices that the solution of a linear system has to have (tracking
/// constraints, Bergou et al. 2007): C x = wanted, each coordinate by itself. With M the masses of
/// free vertices, S = C M^-1 C^T over these is factored as P^T L D L^T P.
struct TrackedRows {
  Index row_count = 0;           ///< 0: no such sums
  Span<const Offset> offset;     ///< [rows + 1] into the next two
  Span<const Index> vertex;      ///< prescribed ones among them
  Span<const double> weight;     ///< C
  Span<const double> mass_inv;   ///< [cloth vertices] [1/kg] zero where the position is prescribed
  Span<const Index> order;       ///< [rows] the row that comes n-th in L
  Span<const Offset> column;     ///< [rows + 1] into the next two: columns of L below the diagonal
  Span<const Index> factor_row;  ///< ascending in a column
  Span<const double> factor;     ///< L, whose diagonal is 1
  Span<const double> pivot;      ///< [rows] D
  Span<const Vec3<double>> wanted;  ///< [rows]
  Span<Vec3<double>> scratch;       ///< [2 rows]
};

}  // namespace weft
