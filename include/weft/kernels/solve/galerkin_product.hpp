#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/coarse_basis.hpp"
#include "weft/state/contact_operator.hpp"

namespace weft {

/// The lowest level on which two reduction blocks are in one domain, if they are on any.
WEFT_HD constexpr int coarse_meeting_level(Index a, Index b) noexcept {
  int level = 0;
  for (a /= coarse_domain, b /= coarse_domain; a != b; a /= coarse_domain, b /= coarse_domain)
    ++level;
  return level;
}

/// Modes of a vertex in the aggregate of `level` around it; level -1: those of its reduction
/// block's, without the last step.
template <class T>
WEFT_HD Modes<T> coarse_basis_at(const CoarseBasisLevels<T>& levels, Index vertex,
                                 int level) noexcept {
  Modes<T> m = levels.unit.data()[vertex / levels.unit_rows](
      coarse_basis_of<T>(levels.point.data()[vertex]));
  Index aggregate = vertex / levels.partial_rows;
  for (int k = 0; k < level; ++k, aggregate /= coarse_domain)
    m = levels.upper[k].larger.data()[aggregate](m);
  return m;
}

/// Galerkin products P^T A P of the preconditioner's levels with linear modes, as far as a rank's
/// rows tell. An entry of the matrix is used once: in the matrix of its reduction block's units,
/// which is inverted here, or on the level on which row and column meet in a domain. Of the former
/// the strip has what is left on the partial sum's aggregate. Reads: the matrices. Writes:
/// levels.fine_inverse, and for each own reduction block and level a strip of its modes (rows)
/// against those of the level's aggregates in its domain (columns). Order: a row's entries in
/// stored order, diagonal before mesh before far before contact, rows in order. Ghosts: none.
/// Prescribed rows take no part.
template <class T>
struct SolveGalerkinProduct {
  Index row_begin = 0;  ///< a multiple of levels.partial_rows
  BlockEll<T> mesh;
  ScalarEll<T> far;  ///< see SolvePcgPart; row_count 0: none
  ContactPart<T> contact;
  Span<const unsigned char> fixed;  ///< [vertices]
  CoarseBasisLevels<T> levels;
  /// [own partials][levels.upper_count][coarse_dofs][coarse_domain_dofs] [kg]
  Span<double> strip;
};

template <class T>
void run(OnHost, Queue& queue, const SolveGalerkinProduct<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveGalerkinProduct<T>& args);

}  // namespace weft
