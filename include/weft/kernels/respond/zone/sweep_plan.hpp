#pragma once

#include <cstdint>

#include "weft/kernels/respond/zone/memory.hpp"
#include "weft/kernels/respond/zone/team.hpp"

namespace weft {

/// Phases in which a team relaxes the constraints of a zone. Those of a phase share no vertex that
/// can move, so that their order makes no difference. What is left after zone_phases_max phases,
/// such as a crowd around one vertex, one worker relaxes in its order.
///
/// The constraints that lead all of their neighbours that have no phase yet get one, round by round
/// (Jones & Plassmann 1993). In order, the lower number leads and a round is a phase: a sweep then
/// gives what plain order gives. Else a scrambled number leads and takes the lowest phase that no
/// neighbour has, which needs fewer rounds and phases.
class SweepPlan {
 public:
  /// @param m     with constraints, and corners of the vertices; on_face is overwritten
  /// @param count constraints
  /// @param worthwhile phases, if not in order
  /// @return false if it would take more phases than that: there is no plan then
  template <class Team>
  WEFT_HD_CALL bool make(Team& team, const ZoneMemory& m, Index count, Index worthwhile) {
    for_each(team, count, [&](Index i) { m.phase[i] = -1; });
    Index round = 0;
    while (round < zone_phases_max &&
           any_of(team, count, [&](Index i) { return m.phase[i] < 0; })) {
      if (!Team::in_order && round == worthwhile) return false;
      for_each(team, count, [&](Index i) {
        m.on_face[i] = m.phase[i] < 0 && leads<Team::in_order>(m, i) ? 1 : 0;
      });
      for_each(team, count, [&](Index i) {
        if (m.on_face[i] != 0) m.phase[i] = Team::in_order ? round : lowest_free(m, i);
      });
      ++round;
    }
    // No phase is higher than the round in which it was given.
    phases_ = round;
    Index begin = 0;
    for (Index phase = 0; phase <= phases_; ++phase) {
      const Index asked = phase < phases_ ? phase : -1;
      if (team.rank() == 0) m.phase_begin[phase] = begin;
      begin += list_where(
          team, count, [&](Index i) { return m.phase[i] == asked; }, m.order + begin);
    }
    if (team.rank() == 0) m.phase_begin[phases_ + 1] = begin;
    team.sync();
    return true;
  }

  /// Calls relax(constraint) for all, phase by phase.
  template <class Team, class Relax>
  WEFT_HD void sweep(Team& team, const ZoneMemory& m, bool forwards, const Relax& relax) const {
    for (Index n = 0; n <= phases_; ++n) {
      const Index phase = forwards ? n : phases_ - n;
      const Index begin = m.phase_begin[phase];
      const Index end = m.phase_begin[phase + 1];
      if (begin == end) continue;
      if (phase < phases_)
        for (Index k = begin + team.rank(); k < end; k += team.size()) relax(m.order[k]);
      else if (team.rank() == 0)
        for (Index k = begin; k < end; ++k) relax(m.order[forwards ? k : begin + end - 1 - k]);
      team.sync();
    }
  }

 private:
  /// Whether test(other) holds for a constraint that shares a vertex that can move.
  template <class Test>
  WEFT_HD static bool any_neighbour(const ZoneMemory& m, Index i, const Test& test) {
    const ZoneConstraint& c = m.constraint[i];
    for (int j = 0; j < 4; ++j) {
      const Index v = c.v[j];
      if (c.w[j] == 0 || m.mass_inv[v] == 0) continue;
      for (Index e = m.corner_begin[v]; e < m.corner_begin[v + 1]; ++e) {
        const Index corner = ZoneMemory::corner_of(m.corner[e]);
        const Index end = m.constraint_begin[corner / 4 + 1];
        for (Index other = m.constraint_begin[corner / 4]; other < end; ++other)
          if (other != i && m.constraint[other].w[corner % 4] != 0 && test(other)) return true;
      }
    }
    return false;
  }

  /// A number per constraint, each another, in no order (the finaliser of MurmurHash3, which is one
  /// to one).
  WEFT_HD static std::uint32_t scrambled(Index i) {
    auto h = static_cast<std::uint32_t>(i);
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
  }

  template <bool in_order>
  WEFT_HD static bool leads(const ZoneMemory& m, Index i) {
    return !any_neighbour(m, i, [&](Index other) {
      if (m.phase[other] >= 0) return false;
      return in_order ? other < i : scrambled(other) < scrambled(i);
    });
  }

  WEFT_HD static Index lowest_free(const ZoneMemory& m, Index i) {
    std::uint64_t taken = 0;
    any_neighbour(m, i, [&](Index other) {
      if (m.phase[other] >= 0) taken |= std::uint64_t{1} << m.phase[other];
      return false;
    });
    Index phase = 0;
    while (phase + 1 < zone_phases_max && (taken >> phase & 1) != 0) ++phase;
    return phase;
  }

  Index phases_ = 0;
};

}  // namespace weft
