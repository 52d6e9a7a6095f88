#pragma once

// How a ZoneQp sweeps: one multiplier after the other, or all at once.

#include <cmath>

#include "weft/kernels/respond/zone/qp.hpp"

namespace weft {

/// Sets a multiplier to what its own constraint asks, given the others.
/// @return whether the constraint was met before
template <class Team>
WEFT_HD bool ZoneQp<Team>::relax(ZoneConstraint& c) const {
  const double missing = c.wanted - gap(c, m_.u);
  const double asked = c.multiplier + missing / c.diagonal;
  const double multiplier = asked > 0 ? asked : 0;
  push(c, multiplier - c.multiplier, m_.u);
  c.multiplier = multiplier;
  return missing <= c.tolerance;
}

/// Relaxes each constraint in turn, or all at once.
/// @return whether every constraint was met when its turn came
template <class Team>
WEFT_HD_CALL bool ZoneQp<Team>::sweep(bool forwards) {
  if (at_once_) return sweep_at_once();
  bool all_met = true;
  if constexpr (Team::alone) {
    for (Index i = 0; i < count_; ++i)
      all_met = relax(m_.constraint[forwards ? i : count_ - 1 - i]) && all_met;
  } else {
    plan_.sweep(team_, m_, forwards,
                [&](Index i) { all_met = relax(m_.constraint[i]) && all_met; });
  }
  ++passes_;
  return !team_.any(!all_met);
}

/// Sum of term(constraint, weight) over the constraints that move vertex v, in their order: those
/// of every stride-th of its corners from the first on.
template <class Team>
template <class Term>
WEFT_HD Vec3<double> ZoneQp<Team>::sum_at(Index v, Index first, Index stride,
                                          const Term& term) const {
  Vec3<double> sum{};
  if (!(m_.mass_inv[v] > 0)) return sum;
  for (Index e = m_.corner_begin[v] + first; e < m_.corner_begin[v + 1]; e += stride) {
    const Index corner = ZoneMemory::corner_of(m_.corner[e]);
    const Index end = m_.constraint_begin[corner / 4 + 1];
    for (Index i = m_.constraint_begin[corner / 4]; i < end; ++i) {
      const double w = m_.constraint[i].w[corner % 4];
      if (w != 0) sum += term(i, w);
    }
  }
  return sum;
}

/// Changes at once all multipliers that are above zero or ask to be. With n_v of them at vertex v,
///   A M^-1 A^T <= diag(sum_j n_v(j) w_j^2 |n|^2 / m_j)   (Cauchy and Schwarz)
/// bounds the curvature of the dual along such changes, so that going by what is missing over that
/// bound cannot lower the dual from where it starts. Multipliers that are and stay zero need not
/// share.
///
/// Such a step starts from beyond the multipliers, in the direction of the latest change and the
/// farther the longer that has helped (Nesterov 1983). As that may itself lower the dual, such a
/// step is taken back if it has, and the next one starts from the multipliers themselves
/// (O'Donoghue & Candes 2015): the dual never falls.
/// @return whether every constraint was met before
template <class Team>
WEFT_HD_CALL bool ZoneQp<Team>::sweep_at_once() {
  const double pace = 0.5 * (1 + std::sqrt(1 + 4 * pace_ * pace_));
  const double beyond = (pace_ - 1) / pace;
  for_each(team_, vertices_, [&](Index v) {
    const Vec3<double> u = m_.u[v];
    if (beyond > 0) m_.u[v] += beyond * (u - m_.u_before[v]);
    m_.u_before[v] = u;
  });
  const bool all_met = !any_of_each(team_, count_, [&](Index i) {
    ZoneConstraint& c = m_.constraint[i];
    const double multiplier = c.multiplier;
    if (beyond > 0) c.multiplier += beyond * (multiplier - m_.before[i]);
    m_.before[i] = multiplier;
    m_.residual[i] = c.wanted - gap(c, m_.u);
    m_.on_face[i] = m_.residual[i] > 0 || c.multiplier != 0 ? 1 : 0;
    return !(m_.residual[i] <= c.tolerance);
  });
  gather_each(
      team_, vertices_,
      [&](Index v, Index first, Index stride) {
        return sum_at(v, first, stride, [&](Index i, double) {
          return Vec3<double>{m_.on_face[i] != 0 ? 1.0 : 0.0, 0, 0};
        });
      },
      [&](Index v, const Vec3<double>& sharing) { m_.trial[v] = sharing; });
  for_each(team_, count_, [&](Index i) {
    m_.search[i] = 0;
    if (m_.on_face[i] == 0) return;
    ZoneConstraint& c = m_.constraint[i];
    double bound = 0;
    for (int j = 0; j < 4; ++j)
      if (bears(c, j)) bound += m_.trial[c.v[j]][0] * c.w[j] * c.w[j] * m_.mass_inv[c.v[j]];
    const double multiplier =
        greater(c.multiplier + m_.residual[i] / (bound * length_sq(c.n)), 0.0);
    m_.search[i] = multiplier - c.multiplier;
    c.multiplier = multiplier;
  });
  gather_each(
      team_, vertices_,
      [&](Index v, Index first, Index stride) {
        return sum_at(v, first, stride, [&](Index i, double w) {
          return (w * m_.search[i] * m_.mass_inv[v]) * m_.constraint[i].n;
        });
      },
      [&](Index v, const Vec3<double>& sum) { m_.u[v] += sum; });
  ++passes_;
  pace_ = pace;
  const double dual = dual_now();
  const bool lower = beyond > 0 && dual < dual_;
  if (lower) {
    for_each(team_, vertices_, [&](Index v) { m_.u[v] = m_.u_before[v]; });
    for_each(team_, count_, [&](Index i) { m_.constraint[i].multiplier = m_.before[i]; });
    pace_ = 1;
  } else {
    dual_ = dual;
  }
  return all_met && !lower;
}

}  // namespace weft
