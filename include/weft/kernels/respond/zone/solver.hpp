#pragma once

#include <cmath>
#include <limits>

#include "weft/core/mat.hpp"
#include "weft/elements/distance.hpp"
#include "weft/kernels/respond/zone/qp.hpp"

namespace weft {

/// Solves the impact zones of a kernel's call one by one. Every worker of the team has one, in the
/// same state.
template <class T, class Team>
class ZoneSolver {
 public:
  WEFT_HD ZoneSolver(const RespondZones<T>& args, Team& team) : a_(args), team_(team) {}

  /// @param memory as ZoneMemory::cut_from() takes it for the zone's collisions
  WEFT_HD_CALL void solve(Index zone, std::byte* memory) {
    const Index begin = a_.zone_begin.data()[zone];
    zone_ = a_.collisions.data() + begin;
    multipliers_ = a_.multipliers.data() + begin;
    size_ = a_.zone_begin.data()[zone + 1] - begin;
    m_ = ZoneMemory::cut_from(memory, size_);
    collect();
    weigh();
    const bool rigid = a_.motion == ZoneMotion::rigid;
    if (!rigid) look_back();
    ZoneOutcome outcome;
    outcome.pinched = pinched() ? 1 : 0;
    outcome.free = free_ ? 1 : 0;
    const bool solved = move(outcome);
    outcome.solved = solved ? 1 : 0;
    if (!rigid)
      for_each(team_, size_, [&](Index k) {
        multipliers_[k].unsolved_rounds = solved ? 0 : unsolved_rounds_ + 1;
      });
    // A zone that cannot move as a body stays as the rounds before have left it.
    if (solved || !rigid) {
      outcome.moved = list_where(
          team_, vertices_, [&](Index i) { return m_.mass_inv[i] != 0; }, m_.face);
      MovedVertex<T>* moved = a_.moved.data() + Offset{4} * begin;
      for_each(team_, outcome.moved, [&](Index k) {
        const Index i = m_.face[k];
        moved[k] = {m_.vertex[i], vec_cast<T>(m_.x[i])};
      });
    }
    if (team_.rank() == 0) a_.outcomes.data()[zone] = outcome;
  }

 private:
  /// Mass of a prescribed vertex that yields, in units of the mean mass of its zone's free ones.
  static constexpr double compliant_mass = 10;
  /// Prescribed vertices pinch a zone if the distances between them change by more than this share
  /// of a collision's offset: far above rounding, far below what cloth would notice.
  static constexpr double pinch_share = 1e-3;
  /// Most prescribed vertices of a zone that are looked at for that.
  static constexpr Index pinch_samples = 128;
  /// Share of the distance at the start that planes keep at least.
  static constexpr double plane_share = 0.9;
  /// Prescribed displacements that differ by more than this share of them are no rigid motion.
  static constexpr double same_displacement = 1e-9;

  WEFT_HD bool prescribed(Index v) const {
    return v >= a_.cloth_vertex_count || a_.fixed.data()[v] != 0;
  }
  WEFT_HD bool heavy(Index v) const { return prescribed(v) && a_.compliant.data()[v] == 0; }
  WEFT_HD Vec3<double> start(Index i) const {
    return vec_cast<double>(a_.positions_t0.data()[m_.vertex[i]]);
  }
  WEFT_HD Vec3<double> free_end(Index i) const {
    return vec_cast<double>(a_.positions_free.data()[m_.vertex[i]]);
  }
  WEFT_HD_CALL void collect();
  WEFT_HD_CALL void weigh();
  WEFT_HD void look_back();
  WEFT_HD_CALL bool pinched();
  WEFT_HD double largest_offset();
  WEFT_HD_CALL double energy_max();
  WEFT_HD bool move(ZoneOutcome& outcome);
  WEFT_HD_CALL bool move_apart(bool planes, ZoneOutcome& outcome);
  template <class Take>
  WEFT_HD_CALL void make_planes(Index k, const Take& take) const;
  WEFT_HD void keep_multipliers(ZoneQp<Team>& qp, bool planes);
  WEFT_HD bool same_pair_as_before(Index k) const;
  WEFT_HD_CALL bool move_rigidly();
  WEFT_HD bool find_prescribed_shift(Vec3<double>& shift);
  WEFT_HD Vec3<double> rotation_of(const Vec3<double>& centre, const Vec3<double>& shift);
  WEFT_HD void turn(const Vec3<double>& centre, const Vec3<double>& shift,
                    const Vec3<double>& spin);

  const RespondZones<T>& a_;
  Team& team_;
  const Collision* zone_ = nullptr;
  ZoneMultipliers* multipliers_ = nullptr;
  Index size_ = 0;  ///< collisions
  ZoneMemory m_;
  Index vertices_ = 0;
  bool free_ = false;             ///< nothing in the zone is prescribed
  bool held_together_ = false;    ///< what is, moves by one `shift_`
  bool latest_excluded_ = false;  ///< the constraints of the latest move_apart() exclude each other
  Index unsolved_rounds_ = 0;     ///< in a row
  Vec3<double> shift_{};          ///< [m] 0 where nothing is
};

/// Local numbers of the zone's vertices, and the corners at each.
template <class T, class Team>
WEFT_HD_CALL void ZoneSolver<T, Team>::collect() {
  const Index corners = 4 * size_;
  for_each(team_, corners,
           [&](Index e) { m_.corner[e] = ZoneMemory::entry_of(zone_[e / 4].v[e % 4], e); });
  team_.sort(m_.corner, corners);
  const auto vertex_of = [&](Index e) { return static_cast<Index>(m_.corner[e] >> 32); };
  vertices_ = list_where(
      team_, corners, [&](Index e) { return e == 0 || vertex_of(e) != vertex_of(e - 1); },
      m_.corner_begin);
  if (team_.rank() == 0) m_.corner_begin[vertices_] = corners;
  team_.sync();
  for_each(team_, vertices_, [&](Index i) {
    m_.vertex[i] = vertex_of(m_.corner_begin[i]);
    for (Index e = m_.corner_begin[i]; e < m_.corner_begin[i + 1]; ++e)
      m_.local[ZoneMemory::corner_of(m_.corner[e])] = i;
  });
}

/// Positions and masses.
template <class T, class Team>
WEFT_HD_CALL void ZoneSolver<T, Team>::weigh() {
  free_ = !any_of(team_, vertices_, [&](Index i) { return prescribed(m_.vertex[i]); });
  const double count =
      sum_of(team_, vertices_, [&](Index i) { return prescribed(m_.vertex[i]) ? 0.0 : 1.0; });
  const double mass = sum_of(team_, vertices_, [&](Index i) {
    const Index v = m_.vertex[i];
    return prescribed(v) ? 0.0 : static_cast<double>(a_.mass.data()[v]);
  });
  for_each(team_, vertices_, [&](Index i) {
    const Index v = m_.vertex[i];
    m_.x[i] = free_end(i);
    if (!prescribed(v))
      m_.mass_inv[i] = 1 / static_cast<double>(a_.mass.data()[v]);
    else if (heavy(v))
      m_.mass_inv[i] = 0;
    else
      m_.mass_inv[i] = count > 0 ? count / (compliant_mass * mass) : 1;
  });
}

/// How many rounds in a row have left the zone unsolved.
template <class T, class Team>
WEFT_HD void ZoneSolver<T, Team>::look_back() {
  unsolved_rounds_ = static_cast<Index>(largest_of(
      team_, size_, [&](Index k) { return static_cast<double>(multipliers_[k].unsolved_rounds); }));
}

template <class T, class Team>
WEFT_HD double ZoneSolver<T, Team>::largest_offset() {
  return largest_of(team_, size_, [&](Index k) { return zone_[k].offset; });
}

/// Whether the zone's prescribed vertices that do not yield move relative to each other.
template <class T, class Team>
WEFT_HD_CALL bool ZoneSolver<T, Team>::pinched() {
  if (free_) return false;
  const double slack = pinch_share * largest_offset();
  const Index* held = m_.face;
  const Index count = list_where(
      team_, vertices_, [&](Index i) { return m_.mass_inv[i] == 0; }, m_.face);
  const Index stride = count / pinch_samples > 1 ? count / pinch_samples : 1;
  return any_of(team_, (count + stride - 1) / stride, [&](Index n) {
    const Index i = held[n * stride];
    for (Index k = (n + 1) * stride; k < count; k += stride) {
      const Index j = held[k];
      if (std::fabs(length(m_.x[j] - m_.x[i]) - length(start(j) - start(i))) > slack) return true;
    }
    return false;
  });
}

template <class T, class Team>
WEFT_HD bool ZoneSolver<T, Team>::move(ZoneOutcome& outcome) {
  if (a_.motion == ZoneMotion::rigid) return move_rigidly();
  held_together_ = find_prescribed_shift(shift_);
  const bool solved = move_apart(a_.motion == ZoneMotion::planes, outcome);
  if (solved || a_.motion == ZoneMotion::planes || !held_together_) return solved;
  if (size_ > zone_planes_at_once && !latest_excluded_ &&
      unsolved_rounds_ < zone_rounds_before_planes)
    return false;
  for_each(team_, vertices_, [&](Index i) { m_.nearly[i] = m_.x[i]; });
  if (move_apart(true, outcome)) return true;
  for_each(team_, vertices_, [&](Index i) { m_.x[i] = m_.nearly[i]; });
  outcome.planes = 0;
  return false;
}

/// @param planes keep the planes of the start, see ZoneMotion
template <class T, class Team>
WEFT_HD_CALL bool ZoneSolver<T, Team>::move_apart(bool planes, ZoneOutcome& outcome) {
  for_each(team_, vertices_, [&](Index i) { m_.x[i] = free_end(i); });
  ZoneQp<Team> qp(team_, m_, vertices_, size_);
  qp.set([&](Index k, const auto& take) {
    const Collision& c = zone_[k];
    if (!planes)
      take(m_.local + 4 * k, c.w, c.n, c.offset, multipliers_[k].impact);
    else if (k == 0 || !same_pair_as_before(k))
      make_planes(k, take);
  });
  const bool in_vain = outcome.pinched != 0 && a_.may_comply;
  int passes_max = in_vain ? pinched_passes_max : zone_passes_max;
  const Offset affordable = a_.visits_max / size_;
  if (affordable < zone_passes_least)
    passes_max = zone_passes_least;
  else if (affordable < passes_max)
    passes_max = static_cast<int>(affordable);
  const bool solved =
      qp.solve(passes_max, planes ? std::numeric_limits<double>::infinity() : energy_max(),
               !planes && held_together_);
  latest_excluded_ = qp.excluded();
  outcome.passes += qp.passes();
  outcome.planes = planes ? 1 : 0;
  for_each(team_, vertices_, [&](Index i) { m_.x[i] += m_.u[i]; });
  keep_multipliers(qp, planes);
  return solved;
}

template <class T, class Team>
WEFT_HD void ZoneSolver<T, Team>::keep_multipliers(ZoneQp<Team>& qp, bool planes) {
  for_each(team_, size_, [&](Index k) {
    if (planes)
      for (double& multiplier : multipliers_[k].planes) multiplier = 0;
    else
      multipliers_[k].impact = 0;
  });
  qp.each_multiplier([&](Index k, Index number, double multiplier) {
    (planes ? multipliers_[k].planes[number] : multipliers_[k].impact) = multiplier;
  });
}

template <class T, class Team>
WEFT_HD bool ZoneSolver<T, Team>::same_pair_as_before(Index k) const {
  const Collision& a = zone_[k - 1];
  const Collision& b = zone_[k];
  return a.first == b.first && a.v[0] == b.v[0] && a.v[1] == b.v[1] && a.v[2] == b.v[2] &&
         a.v[3] == b.v[3];
}

/// Every vertex of the first primitive from every one of the second, along the shortest distance
/// at the start. Where they touch there, no plane is between them: the impact's normal and offset
/// take its place, which the start does not satisfy, so that the zone may gain energy.
template <class T, class Team>
template <class Take>
WEFT_HD_CALL void ZoneSolver<T, Team>::make_planes(Index k, const Take& take) const {
  const Collision& c = zone_[k];
  const Index* local = m_.local + 4 * k;
  Vec3<double> x[4];
  bool held[4];
  for (int j = 0; j < 4; ++j) {
    x[j] = vec_cast<double>(a_.positions_t0.data()[c.v[j]]);
    held[j] = heavy(c.v[j]);
  }
  const Proximity<double> at = c.first == 1 ? vertex_triangle(x) : edge_edge(x);
  const double distance = std::sqrt(at.distance_sq);
  Vec3<double> n = c.n;
  double offset = c.offset;
  if (distance > 0) {
    n = (1 / distance) * at.difference;
    if (plane_share * distance < offset) offset = plane_share * distance;
  }
  if (held[0] && held[1] && held[2] && held[3]) take(local, c.w, n, offset, 0.0);  // unsolvable
  // Which of its collisions is the pair's first may have changed.
  Index number = 0;
  const auto multiplier_of = [&](Index constraint) {
    double sum = multipliers_[k].planes[constraint];
    for (Index other = k + 1; other < size_ && same_pair_as_before(other); ++other)
      sum += multipliers_[other].planes[constraint];
    return sum;
  };
  for (int i = 0; i < c.first; ++i)
    for (int j = c.first; j < 4; ++j) {
      // What no part of can move is as it is.
      if (held[i] && held[j]) continue;
      double w[4] = {};
      w[i] = 1;
      w[j] = -1;
      take(local, w, n, offset, multiplier_of(number++));
    }
}

/// What the dual cannot exceed if the start satisfies the constraints, carried along with what is
/// prescribed, and on top what it takes to bring layers back to their offsets that have come closer
/// than those. Of no use where prescribed vertices move apart.
template <class T, class Team>
WEFT_HD_CALL double ZoneSolver<T, Team>::energy_max() {
  if (!held_together_) return std::numeric_limits<double>::infinity();
  const double offset = largest_offset();
  const auto movable = [&](Index i) { return m_.mass_inv[i] > 0; };
  const double energy = sum_of(team_, vertices_, [&](Index i) {
    if (!movable(i)) return 0.0;
    return 0.5 * length_sq(m_.x[i] - start(i) - shift_) / m_.mass_inv[i];
  });
  const double mass =
      sum_of(team_, vertices_, [&](Index i) { return movable(i) ? 1 / m_.mass_inv[i] : 0.0; });
  return energy + 0.5 * mass * offset * offset;
}

/// Displacement of the vertices of infinite mass; 0 if the zone has none.
/// @return whether they agree on it
template <class T, class Team>
WEFT_HD bool ZoneSolver<T, Team>::find_prescribed_shift(Vec3<double>& shift) {
  shift = {};
  const Index count = list_where(
      team_, vertices_, [&](Index i) { return m_.mass_inv[i] == 0; }, m_.face);
  if (count == 0) return true;
  const auto shift_of = [&](Index k) { return m_.x[m_.face[k]] - start(m_.face[k]); };
  shift = shift_of(count - 1);
  return !any_of(team_, count - 1, [&](Index k) {
    const Vec3<double> one = shift_of(k);
    const Vec3<double> next = shift_of(k + 1);
    return length(next - one) > same_displacement * (length(next) + length(one));
  });
}

/// Momentum of the free vertices, or the displacement of the prescribed ones if the zone has any.
template <class T, class Team>
WEFT_HD_CALL bool ZoneSolver<T, Team>::move_rigidly() {
  Vec3<double> prescribed_shift{};
  if (!find_prescribed_shift(prescribed_shift)) return false;
  const bool held = any_of(team_, vertices_, [&](Index i) { return m_.mass_inv[i] == 0; });
  const auto mass_of = [&](Index i) { return m_.mass_inv[i] == 0 ? 0 : 1 / m_.mass_inv[i]; };
  const double mass = sum_of(team_, vertices_, mass_of);
  if (!(mass > 0)) return false;
  Vec3<double> centre =
      vector_sum_of(team_, vertices_, [&](Index i) { return mass_of(i) * start(i); });
  Vec3<double> shift =
      vector_sum_of(team_, vertices_, [&](Index i) { return mass_of(i) * (m_.x[i] - start(i)); });
  centre *= 1 / mass;
  shift *= 1 / mass;
  const Vec3<double> spin = held ? Vec3<double>{} : rotation_of(centre, shift);
  turn(centre, held ? prescribed_shift : shift, spin);
  return true;
}

/// Turns the zone as it started about `centre` and moves it by `shift`.
template <class T, class Team>
WEFT_HD void ZoneSolver<T, Team>::turn(const Vec3<double>& centre, const Vec3<double>& shift,
                                       const Vec3<double>& spin) {
  const double angle = length(spin);
  for_each(team_, vertices_, [&](Index i) {
    if (m_.mass_inv[i] == 0) return;
    const Vec3<double> r = start(i) - centre;
    Vec3<double> turned = r;
    if (angle > 0) {
      const Vec3<double> axis = (1 / angle) * spin;
      turned = std::cos(angle) * r + std::sin(angle) * cross(axis, r) +
               ((1 - std::cos(angle)) * dot(axis, r)) * axis;
    }
    m_.x[i] = centre + shift + turned;
  });
}

/// Rotation vector over the step that keeps the zone's angular momentum about `centre`.
template <class T, class Team>
WEFT_HD Vec3<double> ZoneSolver<T, Team>::rotation_of(const Vec3<double>& centre,
                                                      const Vec3<double>& shift) {
  const Vec3<double> momentum = vector_sum_of(team_, vertices_, [&](Index i) {
    if (m_.mass_inv[i] == 0) return Vec3<double>{};
    return (1 / m_.mass_inv[i]) * cross(start(i) - centre, m_.x[i] - start(i) - shift);
  });
  Mat3<double> inertia{};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      inertia(row, column) = sum_of(team_, vertices_, [&](Index i) {
        if (m_.mass_inv[i] == 0) return 0.0;
        const Vec3<double> r = start(i) - centre;
        const double own = row == column ? dot(r, r) : 0;
        return (1 / m_.mass_inv[i]) * (own - r[row] * r[column]);
      });
  return inverse_symmetric(inertia) * momentum;
}

}  // namespace weft
