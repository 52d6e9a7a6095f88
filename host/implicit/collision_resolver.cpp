#include "host/implicit/collision_resolver.hpp"

#include <algorithm>
#include <string>

#include "host/implicit/collision_response/failure_place.hpp"
#include "host/implicit/step_failure.hpp"
#include "weft/kernels/integrate/prescribe.hpp"
#include "weft/kernels/respond/apply.hpp"

namespace weft {
namespace {

constexpr int solves_again_max = 2;
/// Rounds in a row that may leave a zone unsolved in which nothing is prescribed, large ones not
/// counted that are to go on first. More of them only add to what it has to meet.
constexpr int unsolved_rounds_max = 3;

/// What joining an impact into zones costs, in visits: each round joins those of all rounds.
constexpr std::int64_t join_visits = 2;

/// [thicknesses] by which prescribed vertices may give way farther in one step: a jump
/// throws the cloth around it, which meets more in the steps after.
constexpr double compliant_at_once = 2;
/// Over the scene's step: shorter ones are not halved for that. Cloth that slides between what
/// overlaps already makes it yield as far in any step.
constexpr double compliance_step_min = 0.4;

/// The motion that zones try after this one has stalled.
ZoneMotion simpler(ZoneMotion motion) {
  return motion == ZoneMotion::impacts ? ZoneMotion::planes : ZoneMotion::rigid;
}

}  // namespace

template <class T>
CollisionResolver<T>::CollisionResolver(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                                        std::vector<RankMotion<T>>& motion,
                                        ContactDetection<T>& detection, LinearSystem<T>& system,
                                        StepSolver<T>& solver,
                                        const PrescribedMotion<T>& prescribed, StageClock& clock,
                                        const StepPublisher& publisher)
    : store_(store),
      motion_(motion),
      detection_(detection),
      solver_(solver),
      prescribed_(prescribed),
      clock_(clock),
      publisher_(publisher),
      zones_(store, geometry, motion),
      energy_(store, motion, system, zones_),
      nominal_step_(store.scene().time.step) {
  for (int r = 0; r < store.devices().size(); ++r) rank_moved_.emplace_back(store.devices()[r]);
}

template <class T>
void CollisionResolver<T>::begin_step(double nominal_step) {
  nominal_step_ = nominal_step;
  energy_.begin_step();
}

template <class T>
void CollisionResolver<T>::publish_budget() const {
  publisher_->set_zone_work(budget_.left() + budget_.reserved(), budget_.granted());
}

template <class T>
void CollisionResolver<T>::begin() {
  DeviceSet& devices = store_.devices();
  for (int r = 0; r < devices.size(); ++r) {
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    devices[r].compute().fill(m.moved_in_attempt.data(), 0, m.moved_in_attempt.size());
  }
  zones_.begin();
  collisions_.clear();
  zone_motion_ = ZoneMotion::impacts;
  unsolved_rounds_ = 0;
  clock_.begin_laps();
}

template <class T>
bool CollisionResolver<T>::resolve(const Attempt& a, StepReport& report) {
  const int rounds_max = store_.scene().contact.zone_rounds;
  // At most one falls on each round and each solve. Rounds and solves have to run out first: how
  // often boxes are made depends on margins that no checkpoint holds.
  const int rebuilds_max = rounds_max + solves_again_max + 3;
  // Each pass makes boxes, solves, responds or looks at all pairs after responses.
  const int passes_max = rebuilds_max + solves_again_max + 2 * rounds_max + 3;
  begin();
  bool later_round = false;
  bool free_saved = false;
  int solves_again = 0;
  int rebuilds = 0;
  int round = 0;
  for (int pass = 0; pass < passes_max; ++pass) {
    const std::size_t first_new = collisions_.size();
    const bool solve_next = a.may_solve_again && !free_saved && solves_again < solves_again_max;
    publisher_.enter(StepStage::detection, report);
    detection_.launch_continuous(later_round, solve_next, report);
    const CollideCounts counts = detection_.collect(collisions_, later_round, solve_next);
    clock_.lap(report.resolve_collisions.detection);
    if (stopped(store_.devices(), report)) return false;
    if (counts.not_finite > 0)
      return fail_not_finite(store_, motion_.front(), counts.not_finite, report);
    if (counts.out_of_bounds > 0) {
      // Some vertex left its swept AABB: the pairs are not all. Search along the actual motion.
      // That is no round of impact zones: how often boxes are made depends on margins that no
      // checkpoint holds, and must not change what these do. So a round that looks at moved
      // vertices' pairs alone stays one: what is listed only now and has not moved was found to be
      // inside boxes that do not meet.
      if (rebuilds++ >= rebuilds_max)
        return fail(report, Failure::intersection, "vertices keep leaving their swept AABBs");
      collisions_.resize(first_new);
      ++report.rebuilds;
      publisher_.enter(StepStage::contacts, report);
      detection_.extend_pairs(a.dt, report);
      clock_.lap(report.resolve_collisions.searches);
      continue;
    }
    if (counts.missed > 0 && solve_next) {
      // Contacts that the prediction missed belong into the system, where all forces meet. Where
      // the system knew of all collisions, it would only come to the same end again.
      collisions_.resize(first_new);
      ++solves_again;
      const StageTimes stages = report.stages;
      detection_.update_contacts(a.dt, report);
      const bool solved = solver_.solve_again(a, report);
      report.stages = stages;  // all of it is part of resolving, the systems' assembly too
      clock_.lap(report.resolve_collisions.solves);
      if (!solved) return false;
      ++round;
      continue;
    }
    report.ccd_tests += counts.ccd_tests;
    report.impacts += counts.collisions;
    if (counts.collisions == 0) {
      if (!later_round) return is_acceptable(a, report);
      // Only pairs that zones have moved were looked at. What is accepted is what all pairs pass.
      later_round = false;
    } else {
      if (round >= rounds_max)
        return fail(report, Failure::intersection,
                    std::to_string(counts.collisions) + " impacts are left after " +
                        std::to_string(round) + " rounds",
                    place_of(store_, collisions_[first_new]));
      if (budget_.left() <= 0)
        return fail(report, Failure::intersection,
                    "impact zones have used up the work of this step",
                    place_of(store_, collisions_[first_new]));
      if (!free_saved) zones_.save_free_end();
      free_saved = true;
      // Simpler motions come after the impacts have had half of the rounds to themselves.
      if (round >= rounds_max / 2)
        zone_motion_ = a.must_stand ? ZoneMotion::rigid : ZoneMotion::planes;
      if (a.must_stand && unsolved_rounds_ > unsolved_rounds_max) zone_motion_ = ZoneMotion::rigid;
      const bool responded = respond(a, first_new, report);
      clock_.lap(report.resolve_collisions.zones);
      if (!responded) return false;
      ++report.zone_rounds;
      later_round = true;
    }
    ++round;
  }
  return fail(report, Failure::intersection,
              "collisions are not resolved after " + std::to_string(passes_max) + " passes");
}

/// A step that leaves no intersection stands, unless something had to yield too far for that, or
/// shorter steps would avoid unexplained energy or a large jump of prescribed vertices.
template <class T>
bool CollisionResolver<T>::is_acceptable(const Attempt& a, StepReport& report) {
  if (a.may_solve_again && !pulled_ && !collisions_.empty()) {
    if (!a.must_stand && energy_.gained(a.dt, collisions_.size(), prescribed_.fixed()))
      return fail(report, Failure::intersection, "impact zones add energy in so long a step");
    if (energy_.stretched(a.dt, a.must_stand))
      return fail(report, Failure::intersection, "impact zones stretch cloth in so long a step");
    if (!a.must_stand && energy_.broke_limits())
      return fail(report, Failure::intersection,
                  "impact zones stretch cloth beyond its strain limits in so long a step");
  }
  if (!zones_.any_compliant()) return true;
  const Scene& scene = store_.scene();
  const auto misses = prescribed_.misses();
  const bool may_be_halved = !a.must_stand && a.dt > compliance_step_min * nominal_step_;
  if (a.may_solve_again && may_be_halved &&
      misses.farther > compliant_at_once * contact_thickness(scene.contact))
    return fail(report, Failure::pinched,
                "obstacles or pins would have to give way too far in one step");
  const bool too_far = misses.over_limit > 1;
  if (!too_far || a.must_stand) {
    report.compliant = std::max(report.compliant, misses.count);
    report.compliance_distance = std::max(report.compliance_distance, misses.distance);
  }
  return !too_far || prescribed_.fail_by(misses, a.dt, report);
}

/// Solves the impact zones and takes their outcome to all ranks (P-Cloth section 4.3).
template <class T>
bool CollisionResolver<T>::respond(const Attempt& a, std::size_t first_new, StepReport& report) {
  const ZoneMotion last = a.must_stand ? ZoneMotion::rigid : ZoneMotion::planes;
  const auto solve_zones = [&] {
    return zones_.solve(
        collisions_, first_new, zone_motion_, prescribed_.fixed(), budget_.left(), [&](int zones) {
          publisher_->set_round(report.zone_rounds + 1, zones,
                                static_cast<std::int64_t>(collisions_.size() - first_new));
        });
  };
  publisher_.enter(StepStage::zones, report);
  ZoneCounts counts = solve_zones();
  while (counts.stalled && zone_motion_ < last) {
    // The remaining rounds would only repeat this one: no large zone goes on from where it is.
    zone_motion_ = simpler(zone_motion_);
    counts = solve_zones();
  }
  if (stopped(store_.devices(), report)) return false;
  if (counts.stalled)
    return fail(report, Failure::intersection,
                std::to_string(collisions_.size() - first_new) +
                    " impacts are left that impact zones do not part",
                place_of(store_, collisions_[first_new]));
  report.zones = std::max(report.zones, counts.zones);
  report.zone_largest = std::max(report.zone_largest, counts.largest);
  report.zone_passes += counts.passes;
  report.zone_visits += counts.visits;
  budget_.spend(counts.visits + join_visits * static_cast<std::int64_t>(collisions_.size()));
  publish_budget();
  report.zones_unsolved += counts.unsolved;
  report.plane_zones += counts.planes;
  if (zone_motion_ == ZoneMotion::rigid) {
    report.rigid_zones += counts.zones;
    report.fallback_level = std::max(report.fallback_level, FallbackLevel::rigid);
  }
  if (zones_.moved().empty() && counts.pinched == 0)
    return fail(report, Failure::intersection, "impact zones that are left do not move",
                place_of(store_, collisions_[first_new]));
  if (zones_.moved().empty())
    return fail(report, Failure::pinched,
                "cloth has no place between prescribed parts: " + zones_.pinched_parts(),
                pinched_place(store_, collisions_, first_new, zones_.pinched()));
  unsolved_rounds_ = counts.unsolved_free > 0 ? unsolved_rounds_ + 1 : 0;
  if (unsolved_rounds_ > unsolved_rounds_max && !a.must_stand)
    return fail(report, Failure::intersection,
                std::to_string(counts.unsolved_free) + " impact zones have no solution");
  apply(zones_.moved(), a.h);
  return true;
}

template <class T>
void CollisionResolver<T>::apply(const std::vector<MovedVertex<T>>& moved, double h) {
  DeviceSet& devices = store_.devices();
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Queue& queue = devices[r].compute();
    RankMotion<T>& m = motion_[n];
    rank_moved_[n].resize(moved.size());
    queue.copy(rank_moved_[n].data(), moved.data(), moved.size() * sizeof(MovedVertex<T>));
    queue.fill(m.moved_now.data(), 0, m.moved_now.size());
    launch(queue, RespondApply<T>{rank_moved_[n].span(), m.base_positions.span(), static_cast<T>(h),
                                  m.positions_t1.span(), m.velocities_t1.span(), m.moved_now.span(),
                                  m.moved_in_attempt.span()});
  }
}

template <class T>
std::vector<Collision> CollisionResolver<T>::collisions_on_the_way(
    const std::vector<MovedVertex<T>>& moves, StepReport& report) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Queue& queue = store_.devices()[r].compute();
    Buffer<Vec3<T>>& end = motion_[n].positions_t1;
    queue.copy(end.data(), store_.rank(r).positions.data(), end.size() * sizeof(Vec3<T>));
    rank_moved_[n].resize(moves.size());
    queue.copy(rank_moved_[n].data(), moves.data(), moves.size() * sizeof(MovedVertex<T>));
    launch(queue, IntegratePrescribe<T>{rank_moved_[n].span(), end.span()});
  }
  detection_.search(store_.scene().time.step, true, report);
  detection_.launch_continuous(false, false, report);
  std::vector<Collision> collisions;
  report.ccd_tests += detection_.collect(collisions, false, false).ccd_tests;
  return collisions;
}

template class CollisionResolver<float>;
template class CollisionResolver<double>;

}  // namespace weft
