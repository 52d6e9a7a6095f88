#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "weft/core/ids.hpp"

namespace weft {

enum class Failure {
  none,
  not_finite,     ///< a NaN or infinity appeared
  not_converged,  ///< the linear solve missed its tolerance
  intersection,   ///< impacts would not resolve
  pinched,        ///< cloth has no place between obstacles or pins, which may not yield so far
  layers,         ///< asynchronous: a pair needs more penalty layers than the scene allows
  rollbacks,      ///< asynchronous: a window was rolled back as often as the scene allows
  small_step,     ///< asynchronous: a penalty layer needs a shorter step than the scene allows
  stopped,        ///< somebody asked for it, see DeviceSet::stop_on()
};

/// Such as "not finite", or "none".
const char* describe(Failure failure);

/// The level at which a step succeeded. Each level does a bounded amount of work.
enum class FallbackLevel {
  whole,   ///< in one piece, with impact zones or without
  halved,  ///< in substeps: the impacts of the whole step did not resolve, or its solve did not
           ///< converge, or that of a step shortly before
  rigid,   ///< at the shortest substep, with some impact zone moved as a rigid body
  failed,  ///< at none; StepReport::failure gives the reason
};

/// "whole", "halved", "rigid" or "failed".
const char* describe(FallbackLevel fallback_level);

/// Wall time of the stages of a step on rank 0. [s]
struct StageTimes {
  double contacts = 0;  ///< broad phase, proximities, their exchange
  double assemble = 0;
  double solve = 0;
  /// Continuous detection and impact zones; its parts: CollisionTimes.
  double resolve_collisions = 0;
  double other = 0;

  double total() const { return contacts + assemble + solve + resolve_collisions + other; }
  StageTimes& operator+=(const StageTimes& b) {
    contacts += b.contacts;
    assemble += b.assemble;
    solve += b.solve;
    resolve_collisions += b.resolve_collisions;
    other += b.other;
    return *this;
  }
};

/// What StageTimes::resolve_collisions went into, by the host's clock; the rest of it is
/// bookkeeping. [s]
struct CollisionTimes {
  double detection = 0;  ///< continuous detection
  double searches = 0;   ///< broad phases that had to be repeated
  /// Linear solves that were repeated with contacts that the prediction missed, and finding these.
  double solves = 0;
  double zones = 0;  ///< impact zones

  double total() const { return detection + searches + solves + zones; }
};

/// What the asynchronous method did: work, and where its time went (Ainsley et al. 2012, figure 1).
struct AsynchronousCounts {
  std::int64_t windows = 0;
  std::int64_t rollbacks = 0;
  std::int64_t clean_windows = 0;  ///< that needed no rollback
  std::int64_t ticks = 0;          ///< of buckets, in accepted passes
  std::int64_t elements = 0;       ///< triangles, hinges and rows of the plate, in accepted passes
  std::int64_t layer_pairs = 0;    ///< pairs that ticks of layers looked at, in accepted passes
  std::int64_t acting_pairs = 0;   ///< those of them that were within the layer
  std::int64_t resimulated = 0;    ///< elements and pairs in passes that were rolled back
  std::int64_t layers_added = 0;   ///< one each time that a pair came within its next layer
  std::int64_t candidates = 0;     ///< pairs that the broad phase left over
  std::int64_t slabs = 0;          ///< separating slabs tried
  std::int64_t failsafe = 0;       ///< candidates that slabs could not decide
  std::int64_t ccd_tests = 0;
  std::int64_t pairs_max = 0;  ///< pairs with active layers at once
  int layers_max = 0;          ///< layers of one pair
  /// Windows that were begun while the one before was looked at, those of them that could go on,
  /// and those that could not: something was found, or expected. And those that were not begun
  /// because that had been so too often of late.
  std::int64_t ahead_started = 0, ahead_accepted = 0, ahead_cancelled = 0, ahead_held = 0;
  double window_length = 0;  ///< [s] of the last window
  double useful = 0;         ///< [s] forces that acted, in accepted passes
  double resimulation = 0;   ///< [s] passes that were rolled back
  double detection = 0;      ///< [s]
  double unneeded = 0;       ///< [s] layers that did not act, in accepted passes
  double bookkeeping = 0;    ///< [s] snapshots, restoring, lists
  /// [s] passes that were begun so, as far as detection hid them: in none of the five above
  double beside_detection = 0;

  AsynchronousCounts& operator+=(const AsynchronousCounts& b);
};

/// What the remeshing after a step did; all zero where there was none.
struct RemeshReport {
  std::int64_t splits = 0;  ///< of edges
  std::int64_t flips = 0;
  std::int64_t collapses = 0;
  std::int64_t refused = 0;   ///< would have met something, or cost too much energy
  std::int64_t redone = 0;    ///< remeshes that would have changed the energy too much as they were
  std::int64_t vertices = 0;  ///< of the cloths afterwards
  std::int64_t triangles = 0;
  double energy_jump = 0;      ///< [J] kinetic, elastic and gravitational, after less before
  double seconds = 0;          ///< wall time
  double rebuild_seconds = 0;  ///< of these: making the model anew
  double cpu_seconds = 0;      ///< of all threads of the process, while it remeshed
  std::int64_t in_view = 0;    ///< triangles of view factor 1; with the method "view"
  double factor_mean = 0;      ///< of the view, by area; likewise
};

/// What a step left out as it was at rest (ImplicitSettings::sleep_distance); zeros where nothing
/// may be.
struct SleepReport {
  std::int64_t pieces = 0;       ///< of cloth, awake or not
  std::int64_t asleep = 0;       ///< vertices that the step left where they were
  std::int64_t fell_asleep = 0;  ///< pieces, before the step
  std::int64_t woken = 0;        ///< pieces, before the step or in it
  /// Times that the step was done again, as something came near what was asleep.
  std::int64_t redone = 0;
  /// [m] by how much a piece may be off by now for having slept, at most, were it to have gone on
  /// as it moved before
  double departure = 0;
};

/// Work of one kind that ranks do side by side, counted: what the busiest of them did in each
/// piece of it, and what each would have done of even shares. Sums over the pieces.
struct SharedWork {
  double busiest = 0;
  double even = 0;

  /// 1: evenly shared, or nothing to do.
  double imbalance() const { return even > 0 ? busiest / even : 1; }
  SharedWork& operator+=(const SharedWork& b) {
    busiest += b.busiest;
    even += b.even;
    return *this;
  }
};

/// How evenly the ranks were busy, and what was done about it; zeros with a single rank.
struct BalanceReport {
  SharedWork rows;       ///< [bytes] that conjugate gradients read and write, in all iterations
  SharedWork box_tests;  ///< of pair searches
  SharedWork pairs;      ///< that were looked at, each time
  SharedWork ccd_tests;  ///< pairs that the cheap test could not decide
  /// The last three together between two searches, as pairs that take as long: what shares of pair
  /// searches follow.
  SharedWork queries;
  int rebalances = 0;           ///< times that rows were shared out anew, before the step
  double seconds = 0;           ///< wall time of that
  double imbalance_before = 0;  ///< of rows, when they were last shared out anew: as they were,
  double imbalance_after = 0;   ///< and by the same counts as they are now

  BalanceReport& operator+=(const BalanceReport& b);
};

/// What one time step did. Counts are those of the accepted attempt and of all attempts before it.
struct StepReport {
  std::int64_t number = 0;  ///< of the step, from 1
  double time = 0;          ///< [s] at its end
  double step = 0;          ///< [s] its length
  int solves = 0;           ///< linear solves
  int iterations = 0;       ///< of PCG, in all solves
  int iterations_max = 0;   ///< in one solve
  double residual_max = 0;  ///< true relative residual
  int newton_iterations = 0;
  /// Where Newton's method stopped, over its first residual; 0: one iteration, not known.
  double newton_residual = 0;
  int active_set_iterations =
      0;                        ///< solves that were repeated because contacts turned out otherwise
  int line_steps = 0;           ///< steps of Newton's method that were shortened
  std::int64_t face_pairs = 0;  ///< that the broad phase found
  std::int64_t edge_pairs = 0;
  std::int64_t proximities = 0;  ///< contacts in the system, at most in one attempt
  std::int64_t impacts = 0;      ///< collisions that were left to impact zones
  std::int64_t ccd_tests = 0;    ///< of detection whose outcome stood
  int zone_rounds = 0;
  int zones = 0;         ///< at most in one round
  int zone_largest = 0;  ///< collisions of the largest zone
  /// Passes over the collisions of a zone, in all zones and rounds.
  std::int64_t zone_passes = 0;
  std::int64_t zone_visits = 0;  ///< of collisions in those passes
  int zones_unsolved = 0;        ///< zones, in all rounds, whose constraints could not all be met
  /// Zones, in all rounds, that kept the planes which part their pairs at the start of the step.
  int plane_zones = 0;
  int rigid_zones = 0;
  FallbackLevel fallback_level = FallbackLevel::whole;
  /// Prescribed vertices - of obstacles, or pinned - that do not end the step where they should,
  /// because they would squeeze cloth between them.
  int compliant = 0;
  double compliance_distance = 0;  ///< [m] by which they miss their places, at most
  double tracking_error = 0;       ///< [m] by which averages miss what they are tied to, at most
  int retries = 0;                 ///< attempts that were given up and halved
  int searches = 0;  ///< broad phases; 0 where the pairs of an earlier step still held
  int rebuilds = 0;  ///< broad phases that had to be repeated within a step
  /// Pairs of cloth with cloth were not looked for: it was proved that none could come near.
  bool self_certified = false;
  double certificate_seconds = 0;     ///< wall time of such proofs, in vain or not
  std::int64_t open_seam_pairs = 0;   ///< not yet welded after the step
  std::int64_t allocations = 0;       ///< of memory, by all ranks
  std::int64_t synchronisations = 0;  ///< waits for rank 0
  Failure failure = Failure::none;
  std::string failure_detail;  ///< one line, empty without failure
  StageTimes stages;
  CollisionTimes resolve_collisions;  ///< zeros with the method asynchronous
  AsynchronousCounts asynchronous;    ///< zeros with other methods
  RemeshReport remesh;
  SleepReport sleep;
  BalanceReport balance;
};

/// [J]; the elastic part includes bending.
struct Energy {
  double kinetic = 0;
  double elastic = 0;
  double gravitational = 0;  ///< zero at the origin's height
};

}  // namespace weft
