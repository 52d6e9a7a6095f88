#pragma once

#include "host/implicit/linear/preconditioners/coarse_basis_table.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/exec/device.hpp"
#include "weft/state/coarse_basis.hpp"

namespace weft {

/// One rank's memory of the preconditioner's levels with linear modes.
template <class T>
class CoarseBasisBuffers {
 public:
  /// @param row_begin first own row, a multiple of the table's partial_rows
  void make(Device& device, const CoarseBasisTable& table, Index row_begin, Index row_count);

  bool any() const { return levels_.any(); }
  CoarseBasisLevels<T> view() const { return levels_; }
  /// [partials][levels][coarse_dofs][coarse_domain_dofs] see SolveGalerkinProduct; own ones and,
  /// once gathered, all
  Span<double> strip() const { return strip_.span(); }
  GatherPiece own_strips() const { return own_strips_; }
  /// Submits the inverses of all levels, from all strips.
  void launch_coarse_inverse(Queue& queue);

 private:
  CoarseBasisLevels<T> levels_;
  GatherPiece own_strips_;
  Buffer<CoarseBasisPoint> point_;
  Buffer<CoarseBasisStep<T>> unit_, larger_[coarse_levels_max];
  Buffer<T> fine_inverse_, inverse_[coarse_levels_max];
  Buffer<double> sum_, move_, strip_, diagonal_[coarse_levels_max];
};

}  // namespace weft
