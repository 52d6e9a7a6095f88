// The last resort of a step: motions that end short of what they would run into.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step.hpp"
#include "weft/kernels/integrate/rate.hpp"

namespace weft {
namespace {

/// Parts that a truncated step may have.
constexpr int approaches_max = 16;
/// By how much the stiffness of contacts grows from one of these solves to the next, and in all:
/// more takes the linear solve too many iterations.
constexpr double stiffness_growth = 2;
constexpr double stiffness_factor_max = 100;
/// [thicknesses] by which prescribed vertices may miss their targets without another solve.
constexpr double lag_least = 0.1;
/// If a solve leaves more than this share of the distance to the targets, and the distance is below
/// this share of its limit, another one hardly helps.
constexpr double lag_left = 0.7;
constexpr double lag_bearable = 0.75;
/// A part that leaves more than this share of the distance is stuck, and the next one is of the
/// other kind. If two in a row are, more parts hardly help.
constexpr double lag_stuck = 0.98;
/// [mean edges] Planes suit prescribed motions up to this length.
constexpr double plane_motion_max = 0.5;
/// Collisions that truncated motions of one step may have over all their rounds, per vertex of the
/// cloth: in the first truncated step in a row, and at least in a later one. With 64 in all, two of
/// eight starts of a sheet in a box that closes end in a pinch, with these none of twelve.
constexpr std::int64_t collisions_per_vertex = 192;
constexpr std::int64_t collisions_per_vertex_least = 64;
/// Cloths of fewer vertices get as many as one of so many.
constexpr std::int64_t vertices_least = 256;
/// Parts before that counts: contacts are stiff enough then to push cloth out of the way.
constexpr int parts_before_stuck = 4;

/// The kind for the next part if the last one got stuck.
/// @param short_motion bodies and pins move little in the step, so separating planes suit them
TruncationKind next(TruncationKind kind, bool short_motion) {
  switch (kind) {
    case TruncationKind::planes:
      return TruncationKind::rides;
    case TruncationKind::rides:
      return TruncationKind::shares;
    case TruncationKind::shares:
      break;
  }
  return short_motion ? TruncationKind::planes : TruncationKind::rides;
}

}  // namespace

/// The step in one piece if prescribed vertices can keep to their limits, else in halves.
/// @param attempted the latest attempt was at this very step, and failed
template <class T>
bool ImplicitStep<T>::advance_truncating(double dt, int bisections_left, bool attempted,
                                         StepReport& report) {
  const double end = store_.time + dt;
  const Attempt a = begin(dt, true);
  const bool in_one = bisections_left == 0 || !contacts_move_too_far(dt);
  if (in_one && !attempted) {
    report.clear_failure();
    grant_zone_visits(zone_budget() / zone_share);
    if (attempt(a, report)) return true;
  }
  if (in_one && collisions_failed(report) && truncate(a, bisections_left > 0, report)) return true;
  if (report.failure == Failure::stopped || bisections_left == 0 || !may_approach()) return false;
  ++report.retries;
  if (!std::exchange(kept_, true)) store_.keep();
  if (!advance_truncating(dt / 2, bisections_left - 1, false, report)) return false;
  if (!advance_truncating(dt / 2, bisections_left - 1, false, report)) return false;
  store_.time = end;  // two halves must end where the whole would have, to the bit
  return true;
}

/// Goes on from an attempt whose collisions could not be resolved: cuts its motion off before it
/// meets something, solves again about the place that it has reached, and repeats this until
/// prescribed vertices are near enough to their targets. Velocities are those of the way that
/// vertices have made, so collisions are inelastic. In the repeated solves contacts start from
/// their normal forces (augmented Lagrangian), which separates layers that are pressed together.
/// @param may_bisect true: fails as soon as prescribed vertices beyond their limits get stuck
template <class T>
bool ImplicitStep<T>::truncate(const Attempt& a, bool may_bisect, StepReport& report) {
  publish_substep(a);
  keep_start();
  bool good = true;
  bool complete = false;
  const bool short_motion = farthest_prescribed() <= plane_motion_max * store_.model().mean_edge;
  TruncationKind kind = short_motion ? TruncationKind::planes : TruncationKind::rides;
  double distance_before = 0;
  double distance_two_before = 0;
  ObstacleCompliance lag;
  for (int pass = 0; good && !complete; ++pass) {
    if (pass > 0) good = approach(a, pass, report);
    if (!good) break;
    cache_contacts(a);
    complete = pass > 0 && resolve_again(a, report);
    good = complete || (collisions_failed(report) && clear_path(a, kind, complete, report));
    if (!good) break;
    report.clear_failure();
    take_part_way();
    lag = measure_compliance();
    const bool stagnates = pass > 0 ? lag.distance > lag_left * distance_before
                                    : lag.farther <= lag_least * store_.scene().contact.thickness;
    if (lag.over_limit <= 1 && (lag.distance <= lag_least * store_.scene().contact.thickness ||
                                (stagnates && lag.over_limit <= lag_bearable)))
      break;
    if (may_bisect && pass >= parts_before_stuck && lag.over_limit > 1 &&
        lag.distance > lag_stuck * distance_two_before)
      break;
    // What is stuck in one way gets on in the other.
    if (pass > 0 && lag.distance > lag_stuck * distance_before) kind = next(kind, short_motion);
    if (pass + 1 >= approaches_max || !may_approach()) break;
    distance_two_before = std::exchange(distance_before, lag.distance);
  }
  search_.hold_normal_forces(0);
  if (good && lag.over_limit > 1) good = fail_compliance(lag, a.dt, report);
  return_to_start(a, good);
  if (!good) return false;
  report.compliant = std::max(report.compliant, lag.count);
  report.compliance_distance = std::max(report.compliance_distance, lag.distance);
  report.fallback_level = FallbackLevel::truncated;
  ++report.truncations;
  accept(a);
  return true;
}

/// How far the farthest prescribed vertex is to move. [m]
template <class T>
double ImplicitStep<T>::farthest_prescribed() {
  Queue& master = store_.devices()[0].compute();
  const std::vector<Vec3<T>> from = download(master, store_.rank(0).positions);
  const std::vector<Vec3<T>> to = download(master, motion_.front().positions_t1);
  double farthest = 0;
  for (std::size_t v = 0; v < from.size(); ++v)
    if (fixed_[v] != 0) farthest = std::max(farthest, static_cast<double>(length(to[v] - from[v])));
  return farthest;
}

/// Grants the work of truncated parts to a step.
template <class T>
void ImplicitStep<T>::grant_approaches() {
  approaches_left_ = approaches_of_step_max;
  truncated_collisions_left_ =
      std::max(collisions_per_vertex_least,
               collisions_per_vertex / (1 + store_.backoff.truncated)) *
      std::max<std::int64_t>(vertices_least, store_.model().cloth_vertex_count);
  board_->set_truncated_solves(0, approaches_left_);
}

/// Keeps the start of the truncated step: its parts take its place until it is over.
template <class T>
void ImplicitStep<T>::keep_start() {
  DeviceSet& devices = store_.devices();
  start_.face_contacts = store_.face_contacts;
  if (start_.ranks.empty())
    for (int r = 0; r < devices.size(); ++r)
      start_.ranks.push_back({Buffer<Vec3<T>>(devices[r]), Buffer<ContactMemory<T>>(devices[r])});
  for (int r = 0; r < devices.size(); ++r) {
    Queue& queue = devices[r].compute();
    const RankState<T>& state = store_.rank(r);
    auto& start = start_.ranks[static_cast<std::size_t>(r)];
    start.positions.resize(state.positions.size());
    start.contacts.grow(state.contacts.size());
    start.contacts.resize(state.contacts.size());
    queue.copy(start.positions.data(), state.positions.data(),
               state.positions.size() * sizeof(Vec3<T>));
    queue.copy(start.contacts.data(), state.contacts.data(),
               state.contacts.size() * sizeof(ContactMemory<T>));
  }
}

/// Solves for the end of the step about the place that the motion has reached.
template <class T>
bool ImplicitStep<T>::approach(const Attempt& a, int pass, StepReport& report) {
  if (stopped(report)) return false;
  --approaches_left_;
  board_->set_truncated_solves(approaches_of_step_max - approaches_left_, approaches_left_);
  enter(StepStage::contacts, report);
  search_.hold_normal_forces(
      std::min(stiffness_factor_max, std::pow(stiffness_growth, static_cast<double>(pass))));
  const auto cloth = static_cast<std::size_t>(store_.model().cloth_vertex_count);
  const std::vector<Vec3<T>>& targets = truncated_.targets();
  for (int r = 0; r < store_.devices().size(); ++r)
    store_.devices()[r].compute().copy(motion_[static_cast<std::size_t>(r)].positions_t1.data(),
                                       targets.data(), targets.size() * sizeof(Vec3<T>));
  search_.search(a.dt, true, report);
  for (int r = 0; r < store_.devices().size(); ++r) {
    const RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    Buffer<Vec3<T>>& x = system_.iterate_positions(r);
    queue.copy(x.data(), store_.rank(r).positions.data(), cloth * sizeof(Vec3<T>));
    queue.copy(x.data() + cloth, m.positions_t1.data() + cloth,
               (x.size() - cloth) * sizeof(Vec3<T>));
    launch(queue, IntegrateRate<T>{x.span(), m.base_positions.span(), static_cast<T>(a.h),
                                   system_.iterate_velocities(r).span()});
  }
  at_ = {a.h, false, false, true, true};
  assemble();
  ++report.newton_iterations;
  return finish_solve(a, {}, report) && iterate_active_set(a, report);
}

/// Impact zones, with little work.
template <class T>
bool ImplicitStep<T>::resolve_again(const Attempt& a, StepReport& report) {
  grant_zone_visits(zone_budget() / zone_share);
  return resolve_collisions({a.dt, a.h, a.at_rest, true, false}, report);
}

/// Cuts the motion to positions_t1 off before it meets something.
/// @param complete set to whether there is nothing that it meets
template <class T>
bool ImplicitStep<T>::clear_path(const Attempt& a, TruncationKind kind, bool& complete,
                                 StepReport& report) {
  Queue& master = store_.devices()[0].compute();
  enter(StepStage::truncation, report);
  prescribe(store_.time + a.dt);  // zones may have moved these vertices
  truncated_.begin(download(master, store_.rank(0).positions),
                   download(master, motion_.front().positions_t1), fixed_, kind,
                   store_.scene().contact.thickness);
  complete = true;
  bool later_round = false;
  int rebuilds = 0;
  int rounds = 0;
  while (true) {
    collisions_.clear();
    search_.launch_continuous(later_round, false, report);
    const CollideCounts counts = search_.collect(collisions_, later_round, false);
    if (stopped(report)) return false;
    if (counts.not_finite > 0)
      return fail(report, Failure::not_finite,
                  std::to_string(counts.not_finite) + " coordinates are not finite",
                  place_not_finite());
    if (counts.out_of_bounds > 0) {
      // Ends move less far with every round, so boxes around the whole motion last.
      if (rebuilds++ > TruncatedMotion<T>::rounds_max)
        return fail(report, Failure::intersection, "vertices keep leaving their swept AABBs");
      ++report.rebuilds;
      search_.search_on_the_way(a.dt, report);
      continue;
    }
    report.ccd_tests += counts.ccd_tests;
    if (counts.collisions == 0 && !later_round) return true;
    if (counts.collisions > 0) {
      // Nothing moves after the last round, so what is left touches at the start of the step.
      if (rounds++ == TruncatedMotion<T>::rounds_max)
        return fail(report, Failure::intersection, "cloth touches at the start of the step",
                    place_of(collisions_.front()));
      complete = false;
      report.impacts += counts.collisions;
      truncated_collisions_left_ -= counts.collisions;
      board_->set_round(report.zone_rounds, 0, counts.collisions);
      apply_moved(truncated_.shorten({collisions_.data(), collisions_.size()}), a);
    }
    // A later round tests only pairs of moved vertices. Motions are accepted once all pairs pass.
    later_round = counts.collisions > 0;
  }
}

/// The end of this part becomes the start of the next one.
template <class T>
void ImplicitStep<T>::take_part_way() {
  DeviceSet& devices = store_.devices();
  sync_ranks(devices);
  if (watch_) watch_(store_.rank(0).positions.span(), motion_.front().positions_t1.span());
  for (int r = 0; r < devices.size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    devices[r].compute().copy(state.positions.data(), m.positions_t1.data(),
                              m.positions_t1.size() * sizeof(Vec3<T>));
    std::swap(state.contacts, m.contacts);
  }
  store_.face_contacts = search_.face_contacts();
}

/// The start of the step takes its place in the state again.
/// @param good the step stands: what its last part has left is its end
template <class T>
void ImplicitStep<T>::return_to_start(const Attempt& a, bool good) {
  DeviceSet& devices = store_.devices();
  for (int r = 0; r < devices.size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = devices[r].compute();
    auto& start = start_.ranks[static_cast<std::size_t>(r)];
    if (good) std::swap(state.contacts, m.contacts);
    std::swap(state.positions, start.positions);
    std::swap(state.contacts, start.contacts);
    if (!good) continue;
    // No history of a multi-step integrator holds across it.
    queue.fill(m.touched.data(), 1, m.touched.size());
    launch(queue, IntegrateRate<T>{m.positions_t1.span(), m.base_positions.span(),
                                   static_cast<T>(a.h), m.velocities_t1.span()});
  }
  if (good) remember_touched(false);
  store_.face_contacts = start_.face_contacts;
  sync_ranks(devices);
}

template bool ImplicitStep<float>::advance_truncating(double, int, bool, StepReport&);
template bool ImplicitStep<double>::advance_truncating(double, int, bool, StepReport&);
template void ImplicitStep<float>::grant_approaches();
template void ImplicitStep<double>::grant_approaches();

}  // namespace weft
