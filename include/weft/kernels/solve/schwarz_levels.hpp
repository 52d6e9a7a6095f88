#pragma once

#include <algorithm>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/contact_operator.hpp"
#include "weft/state/symmetric_blocks.hpp"

namespace weft {

constexpr Index schwarz_aggregates_max = 16;

/// One level of the multilevel preconditioner. Aggregates are 2^shift rows that follow each other
/// in the vertex order, a Morton curve, and move as one; `aggregates` of them form a domain, whose
/// Galerkin matrix R A R^T is inverted whole. Domains never cross the bounds of a reduction block,
/// hence of a rank: the level needs no communication, and does not depend on the number of ranks.
template <class T>
struct SchwarzLevel {
  int shift = 0;
  Index aggregates = 0;  ///< of a domain; 0: the level is not in use
  Span<T> inverse;       ///< domain by domain, see FineLevel and WideLevel [1/kg]

  /// Below two aggregates in a reduction block the level is not in use.
  static constexpr SchwarzLevel of(int shift, Index partial_rows) noexcept {
    const Index aggregates = std::min(schwarz_aggregates_max, partial_rows >> shift);
    return {shift, aggregates < 2 ? 0 : aggregates, {}};
  }

  WEFT_HD constexpr Index domain_rows() const noexcept { return aggregates << shift; }
  WEFT_HD constexpr Index size() const noexcept { return 3 * aggregates; }
  WEFT_HD constexpr Index domains(Index rows) const noexcept {
    return (rows + domain_rows() - 1) / domain_rows();
  }
};

/// Aggregates of 4 rows in domains of 64. Inverses are SymmetricBlocks: products read them whole.
template <class T>
struct FineLevel : SchwarzLevel<T> {
  static constexpr FineLevel of(Index partial_rows) noexcept {
    return {SchwarzLevel<T>::of(2, partial_rows)};
  }
  WEFT_HD constexpr Index domain_numbers() const noexcept {
    return SymmetricBlocks::size(this->aggregates);
  }
  /// Sums that the wide level takes over from each domain, see SolveSchwarzLevels.
  static constexpr Index wide_sums = 9 * schwarz_aggregates_max;
};

/// Aggregates that are domains of the finest level, in domains of 1,024 rows. Inverses are dense,
/// [size][size]: a product reads the rows of an aggregate alone.
template <class T>
struct WideLevel : SchwarzLevel<T> {
  static constexpr WideLevel of(Index partial_rows) noexcept {
    return {SchwarzLevel<T>::of(6, partial_rows)};
  }
  WEFT_HD constexpr Index domain_numbers() const noexcept { return this->size() * this->size(); }
};

/// What a level adds to the preconditioner counts this much, block Jacobi 1: aggregates that move
/// as blocks are too stiff, so more than this corrects modes that finer levels correct as well.
constexpr double schwarz_weight = 0.5;

/// Additive Schwarz on aggregates: the inverses of both levels, as multilevel additive Schwarz (Wu,
/// Wang and Wang 2022) but with aggregates on the finest level too, where block Jacobi stands in.
/// Reads: the matrices. Writes: the levels' inverses. Order: hosts add a fine domain's blocks in
/// stored order, diagonal before mesh before contact, a link of contacts once, at the first row of
/// the domain that it moves, and far multiples of the identity by themselves; CUDA adds those of
/// each aggregate's rows by themselves; always the same. A fine domain is an aggregate of the wide
/// level, which adds up what fine domains have summed.
/// Ghosts: none. Prescribed rows take no part; an empty aggregate gets the identity.
template <class T>
struct SolveSchwarzLevels {
  Index row_begin = 0;  ///< a multiple of domain_rows() of both levels
  BlockEll<T> mesh;
  ScalarEll<T> far;  ///< see SolvePcgPart; row_count 0: none
  ContactOperator<T> contact;
  Span<const unsigned char> fixed;  ///< [vertices]
  FineLevel<T> fine;                ///< in use
  WideLevel<T> wide;                ///< perhaps
  /// [fine domains][wide_sums] scratch for the wide level: a row of blocks of its matrix, the block
  /// on the diagonal and those left of it.
  Span<double> wide_sum;
};

template <class T>
void run(OnHost, Queue& queue, const SolveSchwarzLevels<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveSchwarzLevels<T>& args);

}  // namespace weft
