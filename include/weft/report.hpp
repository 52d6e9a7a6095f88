#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

enum class Failure {
  none,
  not_finite,      ///< a number became NaN or infinite
  not_converged,   ///< the linear solve missed its tolerance
  intersection,    ///< impacts could not be resolved
  pinched,         ///< cloth needs obstacles or pins to give way farther than allowed
  contact_motion,  ///< contacts would move too far in an attempt: it is halved, no step ends so
  layers,          ///< asynchronous: a pair needs more penalty layers than the scene allows
  rollbacks,       ///< asynchronous: a window was rolled back as often as the scene allows
  small_step,      ///< asynchronous: a penalty layer needs a shorter step than the scene allows
  stopped,         ///< the caller asked for it, see DeviceSet::stop_on()
};

/// For example "not finite"; "none" for Failure::none.
const char* describe(Failure failure);

/// The level at which a step succeeded. Each level does a bounded amount of work.
enum class FallbackLevel {
  whole,      ///< in one piece, with or without impact zones
  halved,     ///< in substeps, because impacts could not be resolved in one piece, or because this
              ///< solve or one shortly before did not converge
  rigid,      ///< with at least one impact zone moved as a rigid body
  truncated,  ///< some motion was cut off before what it would have run into
  failed,     ///< no level succeeded; StepReport::failure gives the reason
};

/// "whole", "halved", "rigid", "truncated" or "failed".
const char* describe(FallbackLevel fallback_level);

/// Wall time of the stages of a step on rank 0. [s]
struct StageTimes {
  double contacts = 0;  ///< broad phase, contacts, and their exchange between ranks
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

/// Parts of StageTimes::resolve_collisions, by the host's clock; the remainder is bookkeeping. [s]
struct CollisionTimes {
  double detection = 0;  ///< continuous detection
  double searches = 0;   ///< broad phases that had to be repeated
  /// Linear solves repeated with contacts that the prediction missed, and the search for these.
  double solves = 0;
  double zones = 0;  ///< impact zones

  double total() const { return detection + searches + solves + zones; }
};

/// Work and times of the asynchronous method (Ainsley et al. 2012, figure 1). A pass is one
/// simulation of a window.
struct AsynchronousCounts {
  std::int64_t windows = 0;
  std::int64_t rollbacks = 0;
  std::int64_t clean_windows = 0;  ///< windows without a rollback
  std::int64_t ticks = 0;          ///< of buckets, in accepted passes
  std::int64_t elements = 0;       ///< triangles, hinges and rows of the plate, in accepted passes
  std::int64_t layer_pairs = 0;    ///< pairs that layers tested at their ticks, in accepted passes
  std::int64_t acting_pairs = 0;   ///< of these, pairs that were inside the layer
  std::int64_t resimulated = 0;    ///< elements and pairs in passes that were rolled back
  std::int64_t layers_added = 0;   ///< how often a pair got one more layer
  std::int64_t candidates = 0;     ///< pairs that the broad phase found
  std::int64_t slabs = 0;          ///< separating slabs tried
  std::int64_t failsafe = 0;       ///< candidates that slabs could not decide
  std::int64_t ccd_tests = 0;
  std::int64_t pairs_max = 0;  ///< largest number of pairs with active layers
  int layers_max = 0;          ///< largest number of layers of one pair
  /// Started: windows begun early, while the previous one was checked. Of these, accepted: the
  /// check found nothing; cancelled: it found or expected a contact. Held: windows not begun
  /// early, because recent checks found or expected contacts too often.
  std::int64_t ahead_started = 0, ahead_accepted = 0, ahead_cancelled = 0, ahead_held = 0;
  double window_length = 0;  ///< [s] of the last window
  double useful = 0;         ///< [s] evaluating forces that acted, in accepted passes
  double resimulation = 0;   ///< [s] passes that were rolled back
  double detection = 0;      ///< [s]
  double unneeded = 0;       ///< [s] layers that did not act, in accepted passes
  double bookkeeping = 0;    ///< [s] snapshots, restoring, lists
  /// [s] that passes begun early ran beside detection; not part of the five times above
  double beside_detection = 0;

  AsynchronousCounts& operator+=(const AsynchronousCounts& b);
};

/// Work of the remeshing after a step; zeros if there was none.
struct RemeshReport {
  std::int64_t splits = 0;  ///< of edges
  std::int64_t flips = 0;
  std::int64_t collapses = 0;
  /// Operations that would cause an intersection, or change the energy too much.
  std::int64_t refused = 0;
  std::int64_t redone = 0;    ///< remeshes undone because they changed the energy too much
  std::int64_t vertices = 0;  ///< of the cloths afterwards
  std::int64_t triangles = 0;
  double energy_jump = 0;  ///< [J] kinetic + elastic + gravitational: after minus before
  /// [J] that cloth out of view gained because it resists more of its compression than before, with
  /// the method "view"; not in `energy_jump`.
  double compression_jump = 0;
  double seconds = 0;          ///< wall time
  double rebuild_seconds = 0;  ///< of these: rebuilding the model
  double cpu_seconds = 0;      ///< CPU time of all threads of the process during remeshing
  std::int64_t in_view = 0;    ///< triangles of view factor 1; with the method "view"
  double factor_mean = 0;      ///< view factor, mean by area; with the method "view"
};

/// Cloth that a step skipped because it was at rest (ImplicitSettings::sleep_distance); zeros if
/// nothing may sleep.
struct SleepReport {
  std::int64_t pieces = 0;       ///< components of cloth, awake or asleep
  std::int64_t asleep = 0;       ///< vertices of sleeping components
  std::int64_t fell_asleep = 0;  ///< components that fell asleep before the step
  std::int64_t woken = 0;        ///< components that woke before or during the step
  /// How often the step was repeated because something came near a sleeping component.
  std::int64_t redone = 0;
  /// [m] largest error that sleep may have caused in a component so far, if the component had
  /// kept its velocity and acceleration
  double departure = 0;
};

/// Counted work of one kind that ranks do in parallel. For each parallel section: the work of the
/// busiest rank, and the work per rank if it were shared evenly. Both are summed over sections.
struct SharedWork {
  double busiest = 0;
  double even = 0;

  /// 1 if the work was shared evenly, or if there was none.
  double imbalance() const { return even > 0 ? busiest / even : 1; }
  SharedWork& operator+=(const SharedWork& b) {
    busiest += b.busiest;
    even += b.even;
    return *this;
  }
};

/// How evenly work was shared among ranks, and how often it was redistributed; zeros with a single
/// rank.
struct BalanceReport {
  SharedWork rows;       ///< [bytes] that conjugate gradients read and write, in all iterations
  SharedWork box_tests;  ///< in broad phases
  SharedWork pairs;      ///< pairs that were tested, summed over all passes
  SharedWork ccd_tests;  ///< pairs that the cheap test could not decide
  /// The last three combined, in equivalent pairs, between two broad phases. Queries of the broad
  /// phase are divided among ranks by this.
  SharedWork queries;
  int rebalances = 0;           ///< how often rows were redistributed, before the step
  double seconds = 0;           ///< wall time of that
  double imbalance_before = 0;  ///< of rows, before the last redistribution
  double imbalance_after = 0;   ///< of rows, after it, by the same counts

  BalanceReport& operator+=(const BalanceReport& b);
};

/// Work and outcome of one time step. Counts include all attempts of the step, accepted or not.
struct StepReport {
  std::int64_t number = 0;  ///< of the step, from 1
  double time = 0;          ///< [s] at its end
  double step = 0;          ///< [s] its length
  /// Estimated error of a step of automatic length, over its tolerance; empty with fixed steps.
  std::optional<double> step_error{};
  int rejected = 0;         ///< attempts at a step of automatic length that were too long
  int solves = 0;           ///< linear solves
  int iterations = 0;       ///< of PCG, in all solves
  int iterations_max = 0;   ///< in one solve
  double residual_max = 0;  ///< true relative residual
  int newton_iterations = 0;
  /// Last residual of Newton's method divided by its first; 0: unknown, with a single iteration.
  double newton_residual = 0;
  int active_set_iterations = 0;  ///< solves repeated because the active set changed
  int line_steps = 0;             ///< Newton steps that the line search shortened
  std::int64_t face_pairs = 0;    ///< candidates of the broad phase: vertex and triangle
  std::int64_t edge_pairs = 0;
  std::int64_t proximities = 0;  ///< contacts in the system, maximum over attempts
  std::int64_t impacts = 0;      ///< that impact zones had to resolve
  std::int64_t ccd_tests = 0;    ///< in detections whose result was used
  int zone_rounds = 0;
  int zones = 0;         ///< maximum over rounds
  int zone_largest = 0;  ///< impacts in the largest zone
  /// Passes over the impacts of a zone, in all zones and rounds.
  std::int64_t zone_passes = 0;
  std::int64_t zone_visits = 0;  ///< of impacts in those passes
  int zones_unsolved = 0;        ///< zones, in all rounds, whose constraints could not all be met
  /// Zones, in all rounds, that used separating planes.
  int plane_zones = 0;
  int rigid_zones = 0;
  /// Parts of the step that were cut off before what they would have run into, see docs/methods.
  int truncations = 0;
  FallbackLevel fallback_level = FallbackLevel::whole;
  /// Vertices of obstacles, and pinned vertices, that gave way to pinched cloth: they end the step
  /// away from their targets.
  int compliant = 0;
  double compliance_distance = 0;  ///< [m] largest distance from their targets
  double tracking_error = 0;       ///< [m] largest distance of a tracked average from its target
  int retries = 0;  ///< attempts that failed, or in which obstacles turn too far, and were bisected
  int searches = 0;  ///< broad phases; 0 if the candidates of an earlier step stayed valid
  int rebuilds = 0;  ///< broad phases that had to be repeated within a step
  /// Whether the search for pairs of cloth with cloth was skipped, see self certificate.
  bool self_certified = false;
  double certificate_seconds = 0;    ///< wall time of all such proofs, including failed ones
  std::int64_t open_seam_pairs = 0;  ///< not yet welded after the step
  /// [J] What bodies, pins, handles, seams, wind and pressure gave to the cloth, at most, and what
  /// sewing and remeshing after the step changed; empty: not known.
  std::optional<double> work{};
  /// By how much the worst triangle exceeds a strain limit at the end of a frame, over |limit - 1|;
  /// 0 if none does; empty within frames, or if no material has limits.
  std::optional<double> limit_excess{};
  /// Vertices that move at the end of a frame over all, see RestState; empty within frames, and if
  /// the run does not wait for rest.
  std::optional<double> moving_share{};
  std::int64_t allocations = 0;       ///< of memory, by all ranks
  std::int64_t synchronisations = 0;  ///< how often the host waited for rank 0
  Failure failure = Failure::none;
  std::string failure_detail;  ///< one line, empty without failure
  /// [m] Where it failed; empty if the failure has no place, or none is known.
  std::optional<Vec3<double>> failure_place{};

  /// As if no attempt had failed.
  void clear_failure() {
    failure = Failure::none;
    failure_detail.clear();
    failure_place.reset();
  }
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
  double total() const { return kinetic + elastic + gravitational; }
};

}  // namespace weft
