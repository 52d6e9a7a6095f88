#pragma once

#include <cstdint>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Modes of an aggregate: vertices move as one, and linearly in either material coordinate. Nearly
/// all that cloth can do without stretching is close to that piece by piece; with translations
/// alone, aggregates that turn against each other look as if they tore.
constexpr int coarse_basis_count = 3;
/// Numbers of an aggregate: 3 * mode + component.
constexpr int coarse_dofs = 3 * coarse_basis_count;
/// Aggregates of a domain, whose matrix is inverted whole.
constexpr Index coarse_domain = 16;
constexpr int coarse_domain_dofs = coarse_dofs * static_cast<int>(coarse_domain);
/// Rows of the smallest aggregates at most.
constexpr Index coarse_sub_aggregate_rows_max = 64;
/// Levels of aggregates of one reduction block or more: 16 times as many rows on each.
constexpr int coarse_levels_max = 6;

/// Material coordinates of a vertex in the frame of its unit, in 1/32767 of the frame's size: the
/// frame's origin is the middle of the unit, its size the larger half of the unit's extents.
struct CoarseBasisPoint {
  std::int16_t u = 0, v = 0;
};

/// The two modes that are not constant, at some place.
template <class T>
struct Modes {
  T u, v;
};

/// Modes of a larger aggregate in those of a smaller one within: offset + scale * mode.
template <class T>
struct CoarseBasisStep {
  T u, v, scale;

  WEFT_HD Modes<T> operator()(const Modes<T>& m) const noexcept {
    return {u + scale * m.u, v + scale * m.v};
  }
};

template <class T>
WEFT_HD Modes<T> coarse_basis_of(const CoarseBasisPoint& p) noexcept {
  constexpr T unit = T(1) / T(32767);
  return {unit * static_cast<T>(p.u), unit * static_cast<T>(p.v)};
}

/// Adds a vector at a place to an aggregate's sums, weighed by each mode.
template <class T, class S>
WEFT_HD void add_coarse_basis(const Modes<T>& m, const Vec3<S>& x, T sums[coarse_dofs]) noexcept {
  for (int c = 0; c < 3; ++c) {
    const T value = static_cast<T>(x[c]);
    sums[c] += value;
    sums[3 + c] += m.u * value;
    sums[6 + c] += m.v * value;
  }
}

/// What an aggregate's moves come to at a place: the transpose of add_coarse_basis().
template <class T>
WEFT_HD Vec3<T> move_at(const Modes<T>& m, const T moves[coarse_dofs]) noexcept {
  Vec3<T> x{};
  for (int c = 0; c < 3; ++c) x[c] = moves[c] + m.u * moves[3 + c] + m.v * moves[6 + c];
  return x;
}

/// Adds an aggregate's sums to those of the larger one around it.
template <class T, class S>
WEFT_HD void add_sums(const CoarseBasisStep<T>& step, const S sums[coarse_dofs],
                      S larger[coarse_dofs]) noexcept {
  const S u = step.u, v = step.v, scale = step.scale;
  for (int c = 0; c < 3; ++c) {
    larger[c] += sums[c];
    larger[3 + c] += u * sums[c] + scale * sums[3 + c];
    larger[6 + c] += v * sums[c] + scale * sums[6 + c];
  }
}

/// Adds the moves of the larger aggregate to one within it: the transpose of add_sums().
template <class T, class S>
WEFT_HD void add_coarse_correction(const CoarseBasisStep<T>& step, const S larger[coarse_dofs],
                                   S moves[coarse_dofs]) noexcept {
  const S u = step.u, v = step.v, scale = step.scale;
  for (int c = 0; c < 3; ++c) {
    moves[c] += larger[c] + u * larger[3 + c] + v * larger[6 + c];
    moves[3 + c] += scale * larger[3 + c];
    moves[6 + c] += scale * larger[6 + c];
  }
}

/// A level of aggregates of partial_rows * 16^level rows; coarse_domain of them form a domain.
template <class T>
struct CoarseBasisLevel {
  Index aggregates = 0;                   ///< of the whole system
  Span<const CoarseBasisStep<T>> larger;  ///< [aggregates] to the next level; the last level: none
  Span<T> inverse;  ///< [domains][coarse_domain_dofs][coarse_domain_dofs] [1/kg], every rank alike

  WEFT_HD Index domains() const noexcept {
    return (aggregates + coarse_domain - 1) / coarse_domain;
  }
};

/// All levels of aggregates with linear modes, as one rank has them. The finest one has aggregates
/// of a unit's rows, in domains of a reduction block's: nothing of it reaches over ranks. Units and
/// partial sums are counted through the whole system, so nothing depends on the number of ranks.
template <class T>
struct CoarseBasisLevels {
  Index partial_rows = 0;  ///< 0: not in use
  Index unit_rows = 0;     ///< a power of two, at most partial_rows
  Span<const CoarseBasisPoint> point;
  Span<const CoarseBasisStep<T>> unit;  ///< [units] to the aggregate of the partial sum
  Span<T> fine_inverse;                 ///< [own partials][fine_size()][fine_size()]; 1 unit: none
  int upper_count = 0;
  CoarseBasisLevel<T> upper[coarse_levels_max];
  Span<double> sum;   ///< [2][partials][coarse_dofs] of vectors over partial sums' rows, two epochs
  Span<double> move;  ///< [own partials][3][coarse_dofs] for backends that keep their moves there

  WEFT_HD bool any() const noexcept { return partial_rows > 0; }
  WEFT_HD Index units() const noexcept { return partial_rows / unit_rows; }
  WEFT_HD bool has_fine() const noexcept { return units() > 1; }
  WEFT_HD Index fine_size() const noexcept { return coarse_dofs * units(); }
};

/// Rows of a unit.
WEFT_HD constexpr Index coarse_sub_aggregate_rows(Index partial_rows) noexcept {
  return partial_rows < coarse_sub_aggregate_rows_max ? partial_rows
                                                      : coarse_sub_aggregate_rows_max;
}

/// What a level adds to the preconditioner counts this much, block Jacobi 1: each level corrects
/// what others do too.
constexpr double coarse_weight = 0.5;

/// Share of a Galerkin matrix's diagonal that is added to it. Modes of aggregates with few free
/// vertices, or with all of them in a line, are not independent; without this their matrix might
/// have no inverse.
constexpr double coarse_shift = 1e-6;

}  // namespace weft
