#pragma once

#include <cmath>
#include <limits>

#include "weft/elements/contact.hpp"
#include "weft/elements/scalar.hpp"
#include "weft/kernels/respond/zone/memory.hpp"
#include "weft/kernels/respond/zone/sweep_plan.hpp"
#include "weft/kernels/respond/zone/team.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {

/// The quadratic programme of one impact zone, on its dual: see RespondZones for formula, method
/// and guarantees. In double, whatever the precision of the run. Every worker of the team has one,
/// in the same state, on the same memory.
///
/// What a worker that is alone does constraint by constraint, a team does side by side: it sums the
/// pushes on a vertex by that vertex, in one order, and sweeps as SweepPlan says, or all
/// constraints at once where that would be too many phases. Zones of more than
/// zone_block_collisions are swept at once by all teams.
template <class Team>
class ZoneQp {
 public:
  /// @param vertices   of the zone
  /// @param collisions of the zone
  /// @pre   vertex to corner_begin and mass_inv of the memory are set
  WEFT_HD ZoneQp(Team& team, const ZoneMemory& memory, Index vertices, Index collisions)
      : team_(team), m_(memory), vertices_(vertices), collisions_(collisions) {}

  /// Takes the constraints that make(collision, take) hands to take(v, w, n, offset, multiplier)
  /// for each collision, and starts from those multipliers.
  /// @param make is called more than once for a collision
  template <class Make>
  WEFT_HD void set(const Make& make);

  /// Climbs the dual until all constraints are met.
  /// @param passes_max most passes over the constraints
  /// @param dual_max   [kg m^2] that the dual does not exceed if there is a solution worth having
  /// @param gives_way  if what is missing hardly becomes less
  /// @return           false if the passes did not suffice, if the dual exceeded that, if it has
  ///                   given way, or if none of a collision's vertices can move
  WEFT_HD_CALL bool solve(int passes_max, double dual_max, bool gives_way);

  /// Whether there is no solution worth having, as far as the latest climb() has found out.
  WEFT_HD bool excluded() const { return excluded_ || !solvable_; }

  /// That the latest climb() took.
  WEFT_HD int passes() const { return passes_; }

  /// Calls put(collision, constraint's number among those of the collision, multiplier) for all.
  template <class Put>
  WEFT_HD void each_multiplier(const Put& put) {
    for_each(team_, collisions_, [&](Index k) {
      const Index begin = m_.constraint_begin[k];
      for (Index i = begin; i < m_.constraint_begin[k + 1]; ++i)
        put(k, i - begin, m_.constraint[i].multiplier);
    });
  }

 private:
  /// Sum of the squared weights of vertices that can move from which on a collision is a
  /// constraint: with less these would move ten times as far as the collision is deep.
  static constexpr double free_weight_sq_least = 0.01;
  /// Sweeps before conjugate gradients are tried: most zones are small and need fewer.
  static constexpr int sweeps_at_first = 30;
  /// Most sweeps where conjugate gradients are of no use.
  static constexpr int sweeps_alone_max = 400;
  /// Sweeps between two steps on a face, which find the next face, and before the first where
  /// multipliers are there from an earlier round.
  static constexpr int sweeps_between = 6;
  /// A sweep by more phases than these takes longer than it gets further than one at once.
  static constexpr Index phases_worthwhile = 12;
  /// Passes in which what is missing has to fall below a share of what it was, or giving way is
  /// less work than to go on.
  static constexpr int passes_of_progress = 128;
  static constexpr double progress_share = 0.7;
  /// Share of the tolerance down to which conjugate gradients bring the residual.
  static constexpr double face_accuracy = 0.1;
  /// Curvature, over that of the diagonal alone, under which a direction counts as flat.
  static constexpr double flat = 1e-13;
  /// Share of the diagonal that is added to a matrix that is factorized: redundant constraints
  /// leave it singular.
  static constexpr double ridge = 1e-9;

  /// Whether the constraint reads and moves its vertex j. A worker that is alone adds zeros: that
  /// is faster than to ask.
  WEFT_HD bool bears(const ZoneConstraint& c, int j) const {
    if constexpr (Team::alone) return true;
    return c.w[j] != 0 && m_.mass_inv[c.v[j]] != 0;
  }
  /// Gap that displacements add to a constraint's.
  WEFT_HD double gap(const ZoneConstraint& c, const Vec3<double>* u) const {
    double sum = 0;
    for (int j = 0; j < 4; ++j)
      if (bears(c, j)) sum += c.w[j] * dot(c.n, u[c.v[j]]);
    return sum;
  }
  /// u += M^-1 a multiplier
  WEFT_HD void push(const ZoneConstraint& c, double multiplier, Vec3<double>* u) const {
    for (int j = 0; j < 4; ++j)
      if (bears(c, j)) u[c.v[j]] += (c.w[j] * multiplier * m_.mass_inv[c.v[j]]) * c.n;
  }
  WEFT_HD bool relax(ZoneConstraint& c) const;
  WEFT_HD_CALL bool sweep(bool forwards);
  WEFT_HD_CALL bool sweep_at_once();
  template <class Term>
  WEFT_HD Vec3<double> sum_at(Index v, Index first, Index stride, const Term& term) const;
  WEFT_HD_CALL bool met();
  WEFT_HD double missing();
  WEFT_HD_CALL void combine(const double* multipliers, bool of_face, Vec3<double>* u);
  WEFT_HD_CALL void find_face(Index reach);
  WEFT_HD bool on_face_at(Index v) const;
  WEFT_HD bool grow_face();
  WEFT_HD_CALL bool step_ahead(int passes_max);
  WEFT_HD_CALL void step_on_face(int passes_max);
  WEFT_HD_CALL void find_direction(int passes_max);
  WEFT_HD bool has_factors() const;
  WEFT_HD double coupling(const ZoneConstraint& a, const ZoneConstraint& b) const;
  WEFT_HD_CALL void factorize();
  WEFT_HD_CALL void find_direction_by_factors();
  WEFT_HD_CALL double dual_now();
  WEFT_HD_CALL double dual_along();
  WEFT_HD double energy_of(Index v, const Vec3<double>* u) const;
  template <class MultiplierOf>
  WEFT_HD double dual_of(const MultiplierOf& multiplier_of, const Vec3<double>* u);
  WEFT_HD_CALL double dual(const double* multipliers);
  WEFT_HD_CALL void take(const double* multipliers);

  Team& team_;
  ZoneMemory m_;
  SweepPlan plan_;
  Index vertices_, collisions_;
  Index count_ = 0;       ///< constraints
  Index face_count_ = 0;  ///< of face
  Index reach_ = 1;       ///< links that step_ahead() looks ahead
  bool solvable_ = true;
  bool excluded_ = false;
  bool warm_ = false;     ///< some multiplier is above zero at the start
  bool at_once_ = false;  ///< how sweeps go
  double pace_ = 1;       ///< of sweeps at once; 1: the next starts from the multipliers
  double dual_ = 0;       ///< after the latest, if pace_ is more than 1
  int passes_ = 0;
};

template <class Team>
template <class Make>
WEFT_HD void ZoneQp<Team>::set(const Make& make) {
  const Run run = run_of(team_, collisions_);
  bool solvable = true;
  // What of a collision no vertex can move on is no constraint, and has no solution.
  const auto each = [&](Index collision, const auto& take) {
    make(collision, [&](const Index* v, const double* w, const Vec3<double>& n, double offset,
                        double multiplier) {
      double diagonal = 0;
      double free_sq = 0;
      for (int j = 0; j < 4; ++j) {
        diagonal += w[j] * w[j] * m_.mass_inv[v[j]];
        if (m_.mass_inv[v[j]] > 0) free_sq += w[j] * w[j];
      }
      diagonal *= length_sq(n);
      if (free_sq >= free_weight_sq_least)
        take(v, w, n, offset, multiplier, diagonal);
      else
        solvable = false;
    });
  };
  Index found = 0;
  if constexpr (!Team::alone)
    for (Index k = run.begin; k < run.end; ++k)
      each(k, [&](const Index*, const double*, const Vec3<double>&, double, double, double) {
        ++found;
      });
  Index place = team_.before(found, count_);
  bool warm = false;
  for (Index k = run.begin; k < run.end; ++k) {
    m_.constraint_begin[k] = place;
    each(k, [&](const Index* v, const double* w, const Vec3<double>& n, double offset,
                double multiplier, double diagonal) {
      warm = warm || multiplier > 0;
      m_.cut[place] = multiplier;
      ZoneConstraint& c = m_.constraint[place++];
      c = {{v[0], v[1], v[2], v[3]}, {w[0], w[1], w[2], w[3]}, n, 0, 0, diagonal, 0};
      Vec3<double> x[4];
      for (int j = 0; j < 4; ++j) x[j] = m_.x[v[j]];
      c.wanted = offset - contact_gap(n, x, w);
      c.tolerance = (1 - zone_met_share) * offset;
    });
  }
  if constexpr (Team::alone) count_ = place;
  if (team_.rank() == 0) m_.constraint_begin[collisions_] = count_;
  for_each(team_, vertices_, [&](Index i) { m_.u[i] = {}; });
  solvable_ = !team_.any(!solvable);
  warm_ = team_.any(warm);
  if (warm_) take(m_.cut);
  passes_ = 0;
  reach_ = 1;
  pace_ = 1;
  at_once_ = Team::at_once || collisions_ > zone_block_collisions;
  if constexpr (!Team::at_once && !Team::alone)
    at_once_ = !plan_.make(team_, m_, count_, phases_worthwhile);
}

/// Whether all constraints are met at once.
template <class Team>
WEFT_HD_CALL bool ZoneQp<Team>::met() {
  ++passes_;
  return !any_of(team_, count_, [&](Index i) {
    const ZoneConstraint& c = m_.constraint[i];
    return !(c.wanted - gap(c, m_.u) <= c.tolerance);
  });
}

/// The most by which a constraint is missed, over its tolerance.
template <class Team>
WEFT_HD double ZoneQp<Team>::missing() {
  return largest_of(team_, count_, [&](Index i) {
    const ZoneConstraint& c = m_.constraint[i];
    return (c.wanted - gap(c, m_.u)) / c.tolerance;
  });
}

template <class Team>
WEFT_HD_CALL bool ZoneQp<Team>::solve(int passes_max, double dual_max, bool gives_way) {
  const double movable =
      sum_of(team_, vertices_, [&](Index i) { return m_.mass_inv[i] > 0 ? 1.0 : 0.0; });
  // More constraints than coordinates cannot all hold with equality.
  const bool faces = count_ <= 3 * movable;
  if (!faces && passes_max > sweeps_alone_max) passes_max = sweeps_alone_max;
  int sweeps = warm_ ? sweeps_between : sweeps_at_first;
  double missing_before = std::numeric_limits<double>::infinity();
  int next_look = passes_of_progress;
  bool stepped = false;
  while (passes_ < passes_max) {
    if constexpr (Team::alone)
      if (team_.stopped()) return false;
    for (int k = 0; k < sweeps && passes_ < passes_max; ++k)
      if (sweep(k % 2 == 0) && met()) return solvable_;
    excluded_ = dual_along() > dual_max;
    if (passes_ >= passes_max || excluded_) return false;
    if (gives_way && passes_ >= next_look) {
      const double now = missing();
      if (now > progress_share * missing_before) return false;
      missing_before = now;
      next_look = passes_ + passes_of_progress;
    }
    find_face(0);
    if (!faces && !has_factors()) continue;
    // Most zones are through after one step on the face that sweeps have found.
    if (stepped && step_ahead(passes_max)) {
      if (reach_ < count_) reach_ *= 2;
    } else {
      step_on_face(passes_max);
      reach_ = 1;
    }
    stepped = true;
    sweeps = sweeps_between;
  }
  return false;
}

/// u = M^-1 A^T multipliers
/// @param of_face only of the constraints of the face
template <class Team>
WEFT_HD_CALL void ZoneQp<Team>::combine(const double* multipliers, bool of_face, Vec3<double>* u) {
  if constexpr (Team::alone) {
    for (Index i = 0; i < vertices_; ++i) u[i] = {};
    const Index count = of_face ? face_count_ : count_;
    for (Index k = 0; k < count; ++k) {
      const Index i = of_face ? m_.face[k] : k;
      push(m_.constraint[i], multipliers[i], u);
    }
  } else {
    gather_each(
        team_, vertices_,
        [&](Index v, Index first, Index stride) {
          return sum_at(v, first, stride, [&](Index i, double w) {
            if (of_face && m_.on_face[i] == 0) return Vec3<double>{};
            return (w * multipliers[i] * m_.mass_inv[v]) * m_.constraint[i].n;
          });
        },
        [&](Index v, const Vec3<double>& sum) { u[v] = sum; });
  }
}

/// Conjugate gradients, preconditioned with the diagonal, for the change of the face's multipliers
/// that would meet their constraints exactly. Where they stop early - at the bound, or in a
/// direction without curvature, which redundant constraints have - the dual has risen all the same.
template <class Team>
WEFT_HD_CALL void ZoneQp<Team>::find_direction(int passes_max) {
  if (has_factors()) return find_direction_by_factors();
  for_each(team_, face_count_, [&](Index k) {
    const Index i = m_.face[k];
    m_.direction[i] = m_.search[i] = 0;
    m_.residual[i] = m_.constraint[i].wanted - gap(m_.constraint[i], m_.u);
  });
  double before = 0;
  for (Index step = 0; step < 2 * face_count_ && passes_ < passes_max; ++step, ++passes_) {
    // The greatest residual of the face over its constraint's tolerance.
    if (largest_of(team_, face_count_, [&](Index k) {
          const Index i = m_.face[k];
          return std::fabs(m_.residual[i]) / m_.constraint[i].tolerance;
        }) <= face_accuracy)
      return;
    const double along = sum_of(team_, face_count_, [&](Index k) {
      const Index i = m_.face[k];
      return m_.residual[i] * m_.residual[i] / m_.constraint[i].diagonal;
    });
    const double turn = step == 0 ? 0 : along / before;
    const double scale = sum_of(team_, face_count_, [&](Index k) {
      const Index i = m_.face[k];
      const double diagonal = m_.constraint[i].diagonal;
      m_.search[i] = m_.residual[i] / diagonal + turn * m_.search[i];
      return m_.search[i] * m_.search[i] * diagonal;
    });
    combine(m_.search, true, m_.trial);
    const double curvature = sum_of(team_, face_count_, [&](Index k) {
      const Index i = m_.face[k];
      m_.product[i] = gap(m_.constraint[i], m_.trial);
      return m_.search[i] * m_.product[i];
    });
    if (!(curvature > flat * scale)) return;
    const double length = along / curvature;
    for_each(team_, face_count_, [&](Index k) {
      const Index i = m_.face[k];
      m_.direction[i] += length * m_.search[i];
      m_.residual[i] -= length * m_.product[i];
    });
    before = along;
  }
}

/// Whether a collision at the vertex has a constraint on the face.
template <class Team>
WEFT_HD bool ZoneQp<Team>::on_face_at(Index v) const {
  for (Index e = m_.corner_begin[v]; e < m_.corner_begin[v + 1]; ++e) {
    const Index collision = ZoneMemory::corner_of(m_.corner[e]) / 4;
    for (Index i = m_.constraint_begin[collision]; i < m_.constraint_begin[collision + 1]; ++i)
      if (m_.on_face[i] != 0) return true;
  }
  return false;
}

/// Adds to the face what shares a vertex that can move with it.
/// @return whether there was any
template <class Team>
WEFT_HD bool ZoneQp<Team>::grow_face() {
  if constexpr (Team::alone) {
    for (Index v = 0; v < vertices_; ++v) m_.touched[v] = 0;
    for (Index i = 0; i < count_; ++i)
      if (m_.on_face[i] != 0)
        for (const Index v : m_.constraint[i].v) m_.touched[v] = 1;
  } else {
    for_each(team_, vertices_, [&](Index v) { m_.touched[v] = on_face_at(v) ? 1 : 0; });
  }
  bool grows = false;
  for_each(team_, count_, [&](Index i) {
    bool touches = false;
    for (const Index v : m_.constraint[i].v)
      touches = touches || (m_.touched[v] != 0 && m_.mass_inv[v] > 0);
    if (m_.on_face[i] != 0 || !touches) return;
    m_.on_face[i] = 1;
    grows = true;
  });
  return team_.any(grows);
}

/// The constraints whose multiplier is above zero, and those that `reach` links of shared vertices
/// join to them.
template <class Team>
WEFT_HD_CALL void ZoneQp<Team>::find_face(Index reach) {
  for_each(team_, count_,
           [&](Index i) { m_.on_face[i] = m_.constraint[i].multiplier > 0 ? 1 : 0; });
  for (Index link = 0; link < reach && grow_face();) ++link;
  face_count_ = list_where(
      team_, count_, [&](Index i) { return m_.on_face[i] != 0; }, m_.face);
}

/// A push travels along a chain of impacts by few links a sweep. A step on a face that takes in
/// what lies ahead of it, and drops what turns out to pull, gets there in a logarithm of them.
/// @return whether the dual has risen
template <class Team>
WEFT_HD_CALL bool ZoneQp<Team>::step_ahead(int passes_max) {
  const double before = dual_now();
  find_face(reach_);
  find_direction(passes_max);
  for_each(team_, count_, [&](Index i) {
    m_.projected[i] =
        m_.on_face[i] != 0 ? greater(m_.constraint[i].multiplier + m_.direction[i], 0.0) : 0;
  });
  if (!(dual(m_.projected) > before)) return false;
  take(m_.projected);
  return true;
}

/// Goes to where the constraints of the face would all be met, or as far as the multipliers stay
/// above zero, or where those that do not are set to zero: whatever brings the dual highest.
template <class Team>
WEFT_HD_CALL void ZoneQp<Team>::step_on_face(int passes_max) {
  find_face(0);
  find_direction(passes_max);
  const double share = least_of(team_, face_count_, 1.0, [&](Index k) {
    const Index i = m_.face[k];
    return m_.direction[i] < 0 ? m_.constraint[i].multiplier / -m_.direction[i] : 1.0;
  });
  for_each(team_, count_, [&](Index i) {
    const double multiplier = m_.constraint[i].multiplier;
    const bool may_change = m_.on_face[i] != 0;
    m_.cut[i] = may_change ? greater(multiplier + share * m_.direction[i], 0.0) : 0;
    m_.projected[i] = may_change ? greater(multiplier + m_.direction[i], 0.0) : 0;
  });
  const bool goes_on = share < 1 && dual(m_.projected) > dual(m_.cut);
  take(goes_on ? m_.projected : m_.cut);
}

/// 1/2 |u|^2 of a vertex in the norm of the masses.
template <class Team>
WEFT_HD double ZoneQp<Team>::energy_of(Index v, const Vec3<double>* u) const {
  return m_.mass_inv[v] > 0 ? 0.5 * length_sq(u[v]) / m_.mass_inv[v] : 0;
}

/// The dual at multiplier_of(constraint), which displace by u: one sum over the team.
template <class Team>
template <class MultiplierOf>
WEFT_HD double ZoneQp<Team>::dual_of(const MultiplierOf& multiplier_of, const Vec3<double>* u) {
  double sum = 0, energy = 0;
  for (Index i = team_.rank(); i < count_; i += team_.size())
    sum += multiplier_of(i) * m_.constraint[i].wanted;
  for (Index v = team_.rank(); v < vertices_; v += team_.size()) energy += energy_of(v, u);
  return team_.sum(sum - energy);
}

/// The dual at the multipliers as they stand.
template <class Team>
WEFT_HD_CALL double ZoneQp<Team>::dual_now() {
  return dual_of([&](Index i) { return m_.constraint[i].multiplier; }, m_.u);
}

/// Highest dual of any multiple of the multipliers: that of t of them is t lambda . wanted - t^2 E,
/// E = 1/2 |u|^2. Where there is no solution it grows without bound long before the dual itself
/// does.
template <class Team>
WEFT_HD_CALL double ZoneQp<Team>::dual_along() {
  const double sum = sum_of(team_, count_, [&](Index i) {
    return m_.constraint[i].multiplier * m_.constraint[i].wanted;
  });
  const double e = sum_of(team_, vertices_, [&](Index v) { return energy_of(v, m_.u); });
  if (!(sum > 0)) return 0;
  return e > 0 ? 0.25 * sum * sum / e : std::numeric_limits<double>::infinity();
}

template <class Team>
WEFT_HD_CALL double ZoneQp<Team>::dual(const double* multipliers) {
  combine(multipliers, false, m_.trial);
  ++passes_;
  return dual_of([&](Index i) { return multipliers[i]; }, m_.trial);
}

template <class Team>
WEFT_HD_CALL void ZoneQp<Team>::take(const double* multipliers) {
  for_each(team_, count_, [&](Index i) { m_.constraint[i].multiplier = multipliers[i]; });
  combine(multipliers, false, m_.u);
  pace_ = 1;
}

}  // namespace weft

#include "weft/kernels/respond/zone/face_factors.hpp"
#include "weft/kernels/respond/zone/sweeps.hpp"
