#pragma once

#include <algorithm>
#include <vector>

#include "weft/core/vec.hpp"
#include "weft/state/coarse_basis.hpp"

namespace weft {

/// The part of the preconditioner that aggregates with linear modes add, for one rank. What the
/// levels above a partial sum add to u is linear in the sums of r over the partial sums' modes, and
/// r goes by a recurrence; so their moves go by the same one, from sums of w that travel with the
/// partial sums of the dot products. No reduction of its own, but one a restart.
template <class T>
class CoarseCorrection {
 public:
  CoarseCorrection(const CoarseBasisLevels<T>& levels, Index begin, Index rows)
      : levels_(levels), begin_(begin), rows_(rows) {
    if (!any()) return;
    first_partial_ = static_cast<std::size_t>(begin_ / levels_.partial_rows);
    partials_ = static_cast<std::size_t>((rows_ + levels_.partial_rows - 1) / levels_.partial_rows);
    for (int k = 0; k < levels_.upper_count; ++k) {
      const auto size = coarse_dofs * static_cast<std::size_t>(levels_.upper[k].aggregates);
      sums_[k].resize(size);
      moves_[k].resize(size);
    }
    r_moves_.resize(coarse_dofs * partials_);
    s_moves_.resize(coarse_dofs * partials_);
  }

  bool any() const { return levels_.any(); }

  /// Sums of own rows of a vector, for all ranks to take.
  void sum(Span<const Vec3<T>> vector, std::size_t parity) const {
    double* out = levels_.sum.data() + set(parity) + coarse_dofs * first_partial_;
    for (Index row = 0; row < rows_; row += levels_.partial_rows, out += coarse_dofs) {
      std::fill(out, out + coarse_dofs, 0.0);
      const Index end = std::min(rows_, row + levels_.partial_rows);
      for (Index unit = row; unit < end; unit += levels_.unit_rows) {
        double of_unit[coarse_dofs] = {};
        for (Index i = unit; i < std::min(end, unit + levels_.unit_rows); ++i)
          add_coarse_basis(coarse_basis_of<double>(point(i)), vector.data()[i], of_unit);
        add_sums(unit_step(unit), of_unit, out);
      }
    }
  }

  /// Takes a peer's sums of partial sums [first, last).
  void take(const CoarseBasisLevels<T>& peer, std::size_t parity, std::size_t first,
            std::size_t last) {
    const double* theirs = peer.sum.data() + set(parity);
    std::copy(theirs + coarse_dofs * first, theirs + coarse_dofs * last,
              sums_[0].begin() + static_cast<std::ptrdiff_t>(coarse_dofs * first));
  }

  /// The sums taken are those of r.
  void restart() {
    solve_coarse_inverse();
    copy_own_moves(r_moves_);
  }

  /// The sums taken are those of w: s = w + beta s, r -= alpha s.
  void advance(double alpha, double beta) {
    solve_coarse_inverse();
    const double* w = moves_[0].data() + coarse_dofs * first_partial_;
    for (std::size_t n = 0; n < r_moves_.size(); ++n) {
      s_moves_[n] = w[n] + (beta == 0 ? 0 : beta * s_moves_[n]);
      r_moves_[n] -= alpha * s_moves_[n];
    }
  }

  /// u += what all levels make of r, in free own rows.
  void correct(Span<const Vec3<T>> r, Span<const unsigned char> fixed, Span<Vec3<T>> u) const {
    const Index units = levels_.units();
    std::vector<T> sums(coarse_dofs * static_cast<std::size_t>(units)), moves(sums.size());
    for (std::size_t n = 0; n < partials_; ++n) {
      const Index first = static_cast<Index>(n) * levels_.partial_rows;
      const Index end = std::min(rows_, first + levels_.partial_rows);
      std::fill(moves.begin(), moves.end(), T(0));
      if (levels_.has_fine()) solve_fine(n, r, sums, moves);
      T upper[coarse_dofs];
      for (std::size_t k = 0; k < coarse_dofs; ++k)
        upper[k] = static_cast<T>(r_moves_[coarse_dofs * n + k]);
      for (Index unit = 0; first + unit * levels_.unit_rows < end; ++unit) {
        T* move = moves.data() + coarse_dofs * unit;
        add_coarse_correction(unit_step(first + unit * levels_.unit_rows), upper, move);
        const Index row = first + unit * levels_.unit_rows;
        for (Index i = row; i < std::min(end, row + levels_.unit_rows); ++i)
          if (fixed.data()[begin_ + i] == 0)
            u.data()[begin_ + i] +=
                static_cast<T>(coarse_weight) * move_at(coarse_basis_of<T>(point(i)), move);
      }
    }
  }

 private:
  const CoarseBasisPoint& point(Index row) const { return levels_.point.data()[begin_ + row]; }
  const CoarseBasisStep<T>& unit_step(Index row) const {
    return levels_.unit.data()[(begin_ + row) / levels_.unit_rows];
  }
  std::size_t set(std::size_t parity) const {
    return parity * coarse_dofs * static_cast<std::size_t>(levels_.upper[0].aggregates);
  }
  void copy_own_moves(std::vector<double>& to) const {
    const auto first =
        moves_[0].begin() + static_cast<std::ptrdiff_t>(coarse_dofs * first_partial_);
    std::copy(first, first + static_cast<std::ptrdiff_t>(to.size()), to.begin());
  }

  /// Moves of own partial sums' units, from r in their rows.
  void solve_fine(std::size_t partial, Span<const Vec3<T>> r, std::vector<T>& sums,
                  std::vector<T>& moves) const {
    const Index first = static_cast<Index>(partial) * levels_.partial_rows;
    std::fill(sums.begin(), sums.end(), T(0));
    for (Index i = first; i < std::min(rows_, first + levels_.partial_rows); ++i)
      add_coarse_basis(coarse_basis_of<T>(point(i)), r.data()[i],
                       sums.data() + coarse_dofs * ((i - first) / levels_.unit_rows));
    const std::size_t n = sums.size();
    const T* inverse = levels_.fine_inverse.data() + partial * n * n;
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t i = 0; i < n; ++i) moves[i] += inverse[k * n + i] * sums[k];
  }

  /// Moves of the partial sums by the sums taken: up through the levels, and down again.
  void solve_coarse_inverse() {
    for (int k = 0; k + 1 < levels_.upper_count; ++k) {
      std::fill(sums_[k + 1].begin(), sums_[k + 1].end(), 0.0);
      for (Index i = 0; i < levels_.upper[k].aggregates; ++i)
        add_sums(levels_.upper[k].larger.data()[i], sums_[k].data() + coarse_dofs * i,
                 sums_[k + 1].data() + coarse_dofs * (i / coarse_domain));
    }
    for (int k = levels_.upper_count; k-- > 0;) {
      const bool own = k == 0;
      const Index first = own ? static_cast<Index>(first_partial_) : 0;
      const Index end =
          own ? static_cast<Index>(first_partial_ + partials_) : levels_.upper[k].aggregates;
      for (Index i = first; i < end; ++i) solve_aggregate(k, i);
    }
  }

  void solve_aggregate(int level, Index aggregate) {
    const CoarseBasisLevel<T>& l = levels_.upper[level];
    const Index domain = aggregate / coarse_domain;
    const Index count =
        coarse_dofs * (std::min(coarse_domain, l.aggregates - domain * coarse_domain));
    const double* sums = sums_[level].data() + coarse_dofs * domain * coarse_domain;
    double* moves = moves_[level].data() + coarse_dofs * aggregate;
    const T* inverse = l.inverse.data() +
                       static_cast<std::size_t>(domain) * coarse_domain_dofs * coarse_domain_dofs +
                       coarse_dofs * (aggregate % coarse_domain) * coarse_domain_dofs;
    for (int i = 0; i < coarse_dofs; ++i, inverse += coarse_domain_dofs) {
      moves[i] = 0;
      for (Index k = 0; k < count; ++k) moves[i] += static_cast<double>(inverse[k]) * sums[k];
    }
    if (level + 1 < levels_.upper_count)
      add_coarse_correction(l.larger.data()[aggregate],
                            moves_[level + 1].data() + coarse_dofs * domain, moves);
  }

  const CoarseBasisLevels<T>& levels_;
  Index begin_, rows_;
  std::size_t first_partial_ = 0, partials_ = 0;
  std::vector<double> sums_[coarse_levels_max], moves_[coarse_levels_max];
  std::vector<double> r_moves_, s_moves_;  ///< [own partials][coarse_dofs]
};

}  // namespace weft
