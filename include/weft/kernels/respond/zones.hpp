#pragma once

#include <atomic>
#include <cstddef>
#include <limits>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/respond/zone/memory.hpp"
#include "weft/state/contact.hpp"
#include "weft/state/moved_vertex.hpp"

namespace weft {

/// How the vertices of a zone may move.
enum class ZoneMotion {
  /// So that every impact has its offset along its normal. If that fails, the zone moves as
  /// `planes`, provided that its prescribed vertices share one displacement. A large zone has to
  /// fail
  /// several times first.
  impacts,
  /// So that the planes that separate the pairs at the start of the step still do. The planes move
  /// along with the prescribed vertices.
  planes,
  rigid,  ///< as one body
};

/// Outcome of one zone.
struct ZoneOutcome {
  Index moved = 0;            ///< vertices that were written
  Index passes = 0;           ///< over the zone's collisions, see zone_passes_max
  unsigned char solved = 0;   ///< 1: every constraint is met
  unsigned char pinched = 0;  ///< 1: prescribed vertices move relative to each other
  unsigned char free = 0;     ///< 1: nothing in the zone is prescribed
  unsigned char planes = 0;   ///< 1: solved as ZoneMotion::planes
};

/// Multipliers of a collision, from one round to the next.
struct ZoneMultipliers {
  double impact = 0;          ///< [kg m] impulse times step along its normal
  double planes[4] = {};      ///< [kg m] of its pair's planes, at the first of a pair's collisions
  Index unsolved_rounds = 0;  ///< consecutive rounds without a solution of its zone
};

/// Most passes over the collisions of a zone: a sweep is one, a conjugate gradient step another.
inline constexpr int zone_passes_max = 2000;
/// The same for a pinched zone, which often has no solution.
inline constexpr int pinched_passes_max = 60;
/// Passes that RespondZones::visits_max leaves to every zone.
inline constexpr int zone_passes_least = 30;
/// A zone of at most so many collisions moves as `planes` as soon as its impacts cannot all be met.
inline constexpr Index zone_planes_at_once = 512;
/// A larger zone does so only after this many consecutive rounds without a solution. Each round
/// continues from the multipliers of the one before, and most such zones have a solution after all.
/// Planes would start again, with several times the constraints.
inline constexpr Index zone_rounds_before_planes = 3;
/// A constraint counts as met once this share of its offset is restored; the continuous test asks
/// for less, so that a zone that has been solved stays solved.
inline constexpr double zone_met_share = 0.8;

/// Inelastic impact zones (P-Cloth section 4.3; Harmon et al. 2008): for each connected set of
/// collisions, the change of the end positions that is smallest in the norm of the masses and
/// restores every collision's offset along its normal,
///   min 1/2 sum_i m_i |x_i - x*_i|^2   subject to   n_k . sum_j w_kj x_kj >= offset_k.
/// P-Cloth and Tang et al. 2018 take that to an augmented Lagrangian with a penalty mu, and descend
/// on x between updates of the multipliers lambda. As the objective is quadratic and the normals
/// are those of the impacts, x = x* + M^-1 A^T lambda holds for any lambda, and what is left is the
/// dual, max over lambda >= 0 of
///   D(lambda) = lambda . (offset - A x*) - 1/2 lambda . A M^-1 A^T lambda.
/// It is climbed by sweeps that set each multiplier to what its own constraint asks (the update of
/// the augmented Lagrangian with mu = 1 / (A M^-1 A^T)_kk and an exact inner step), and, where
/// those are slow - knots, long chains of impacts, masses far apart -, by solving for the
/// multipliers that are not zero, cut off or projected where one becomes negative: up to
/// zone_factor_max of them by factors of their matrix, more by conjugate gradients. D never falls,
/// and wherever one stops
///   kinetic energy before - after >= 2 D(lambda) / h^2 >= 0   if the start satisfies the offsets,
/// linear momentum is kept, and so is angular momentum about the positions that the normals are of.
///
/// A round adds impacts to those of the rounds before. Multipliers that these have left are where
/// the climb begins: as ends without response, masses and normals are the same, D is there what it
/// was, whatever zones have become one. The caller forgets them where masses change, and for each
/// step.
///
/// Normals of impacts turn within a fast step, so that the start need not satisfy all of them, and
/// what has no solution, or one that only a gain of energy would reach, is asked for less exactly:
/// the normal n of the shortest distance at the start parts the two primitives there, and
///   n . (x_i - x_j) >= offset   for every vertex i of the first and j of the second
/// at both ends of the step keeps them parted all the way, as it is linear in time. The start
/// satisfies that, carried along with whatever in the zone is prescribed, if that moves by one
/// displacement: such a zone always has a solution, and a pair that has been part of one does not
/// collide again. Where two primitives touch at the start, nothing is between them: the normal and
/// the offset of their impact are what is asked of all of their vertices then.
///
/// Vertices of obstacles and fixed ones have infinite mass. Those that yield - which the caller
/// decides, where they squeeze a zone - have several times that of the zone's cloth instead.
/// A zone that moves rigidly keeps its linear and angular momentum, or follows the prescribed
/// motion that touches it (Provot 1997; Bridson et al. 2002).
///
/// Reads: collisions, positions, multipliers. Writes: multipliers, moved, outcomes, of each zone in
/// its own place. Order: the
/// result depends on the order of a zone's collisions and on no other zone. Ghosts: all vertices of
/// the zones. Flags: not solved, pinched.
///
/// On a GPU a warp solves a zone of up to zone_warp_collisions, sweeping in the host's order: what
/// sweeps solve has the host's bits, and what takes conjugate gradients or a rigid motion differs
/// by the order of sums. A block solves a larger one, sweeping in phases of constraints that share
/// no vertex, and all processors one of more than zone_block_collisions. Zones of more than that
/// change all multipliers of a sweep at once, on the host too. Either way stops at another place
/// where all constraints are met: see zone/sweep_plan.hpp and ZoneQp::sweep_at_once().
template <class T>
struct RespondZones {
  Span<const Collision> collisions;    ///< zone by zone
  Span<const Index> zone_begin;        ///< [zones + 1] into collisions
  Span<const Vec3<T>> positions_t0;    ///< [vertices] [m] start of the step
  Span<const Vec3<T>> positions_free;  ///< [vertices] [m] end of the step before any response
  Span<const T> mass;                  ///< [cloth vertices] [kg]
  Span<const unsigned char> fixed;     ///< [cloth vertices]
  Index cloth_vertex_count = 0;
  ZoneMotion motion = ZoneMotion::impacts;
  Span<const unsigned char> compliant;  ///< [vertices] 1: prescribed, but yields in this step
  /// [collisions] where to begin, then where it ended; neither if the motion is rigid
  Span<ZoneMultipliers> multipliers;
  Span<MovedVertex<T>> moved;  ///< [4 collisions] a zone's from 4 zone_begin on, ascending
  Span<ZoneOutcome> outcomes;  ///< [zones]
  /// [zone_scratch_bytes()] working memory of a GPU, aligned as double; the host has its own
  Span<std::byte> scratch;
  /// Once true, the kernel ends early and its output is undefined. Null: never. Host only.
  const std::atomic<bool>* stop = nullptr;
  /// Most visits of collisions in all passes over a zone; zone_passes_least passes are always made.
  Offset visits_max = std::numeric_limits<Offset>::max();
  /// Prescribed vertices may give way: a pinched zone that has no solution need not be looked at
  /// for long.
  bool may_comply = true;
};

/// Most collisions of a zone that a warp solves.
inline constexpr Index zone_warp_collisions = 32;
/// Most collisions of a zone that a block solves.
inline constexpr Index zone_block_collisions = 2048;

/// Bytes of RespondZones::scratch.
constexpr std::size_t zone_scratch_bytes(std::size_t collisions, std::size_t zones) {
  return collisions * ZoneMemory::collision_bytes + zones * ZoneMemory::zone_bytes;
}

template <class T>
void run(OnHost, Queue& queue, const RespondZones<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const RespondZones<T>& args);

}  // namespace weft
