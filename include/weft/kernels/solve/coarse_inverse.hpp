#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/coarse_basis.hpp"

namespace weft {

/// The inverses of one level of aggregates, of all domains: every rank makes them alike. Levels
/// follow each other, since a level's diagonal blocks are what the domains of the one below leave.
/// Reads: all ranks' strips, see SolveGalerkinProduct, and the diagonal of the level. Writes: the
/// level's inverses, symmetric to the bit; the next level's diagonal blocks. Order: partial sums in
/// order.
template <class T>
struct SolveCoarseInverse {
  CoarseBasisLevels<T> levels;
  int level = 0;
  Span<const double> strip;     ///< [partials][levels.upper_count][coarse_dofs][coarse_domain_dofs]
  Span<const double> diagonal;  ///< [aggregates][coarse_dofs^2] [kg]; level 0: none
  Span<double> next_diagonal;   ///< [domains][coarse_dofs^2] [kg]; last level: none
};

template <class T>
void run(OnHost, Queue& queue, const SolveCoarseInverse<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveCoarseInverse<T>& args);

}  // namespace weft
