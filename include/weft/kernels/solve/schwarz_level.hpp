#pragma once

#include <algorithm>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/contact_operator.hpp"

namespace weft {

/// One level of the multilevel preconditioner. Aggregates are 2^shift rows that follow each other
/// in the vertex order, a Morton curve, and move as one; `aggregates` of them form a domain, whose
/// Galerkin matrix R A R^T is inverted whole. Domains never cross the bounds of a reduction block,
/// hence of a rank: the level needs no communication, and does not depend on the number of ranks.
template <class T>
struct SchwarzLevel {
  int shift = 0;
  Index aggregates = 0;  ///< of a domain
  Span<T> inverse;       ///< [domains][3 aggregates][3 aggregates] [1/kg]

  WEFT_HD Index domain_rows() const noexcept { return aggregates << shift; }
  WEFT_HD Index size() const noexcept { return 3 * aggregates; }
};

constexpr int schwarz_level_count = 2;
constexpr Index schwarz_aggregates_max = 16;

/// Rows of an aggregate as a power of two, level by level: domains of 64 and of 1,024 rows.
constexpr int schwarz_shift(int level) noexcept {
  return 2 + 4 * level;
}

/// Aggregates of a domain; below 2 the level is left out.
constexpr Index schwarz_aggregates(int level, Index partial_rows) noexcept {
  return std::min(schwarz_aggregates_max, partial_rows >> schwarz_shift(level));
}

/// What a level adds to the preconditioner counts this much, block Jacobi 1: aggregates that move
/// as blocks are too stiff, so more than this corrects modes that finer levels correct as well.
constexpr double schwarz_weight = 0.5;

/// Additive Schwarz on aggregates: the inverses of one level, as multilevel additive Schwarz (Wu,
/// Wang and Wang 2022) but with aggregates on the finest level too, where block Jacobi stands in.
/// Reads: the matrices. Writes: the level's inverses. Order: hosts add a domain's blocks in stored
/// order, diagonal before mesh before contact, and far multiples of the identity by themselves;
/// CUDA adds those of each block and quarter of its rows, quarters then pairwise: always the same.
/// Ghosts: none. Prescribed rows take no part; an empty aggregate gets the identity.
template <class T>
struct SolveSchwarzLevel {
  Index row_begin = 0;  ///< a multiple of domain_rows()
  BlockEll<T> mesh;
  ScalarEll<T> far;  ///< see SolvePcgPart; row_count 0: none
  ContactOperator<T> contact;
  Span<const unsigned char> fixed;  ///< [vertices]
  SchwarzLevel<T> level;
};

template <class T>
void run(OnHost, Queue& queue, const SolveSchwarzLevel<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveSchwarzLevel<T>& args);

}  // namespace weft
