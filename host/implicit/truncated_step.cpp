#include "host/implicit/truncated_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "host/implicit/collision_response/failure_place.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step_failure.hpp"
#include "weft/kernels/integrate/rate.hpp"

namespace weft {
namespace {

/// Solves that truncated parts of a step may take.
constexpr int approaches_of_step_max = 128;
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

template <class T>
TruncatedStep<T>::TruncatedStep(Store<T>& store, std::vector<RankMotion<T>>& motion,
                                ContactDetection<T>& detection, StepSolver<T>& solver,
                                PrescribedMotion<T>& prescribed, CollisionResolver<T>& resolver,
                                StateUpdate<T>& update, StageClock& clock,
                                const StepPublisher& publisher)
    : store_(store),
      motion_(motion),
      detection_(detection),
      solver_(solver),
      prescribed_(prescribed),
      resolver_(resolver),
      update_(update),
      clock_(clock),
      publisher_(publisher) {}

template <class T>
bool TruncatedStep<T>::advance(const Attempt& a, bool may_bisect, const Watch& watch,
                               StepReport& report) {
  clock_.mark(StageClock::solved);
  keep_start();
  bool good = true;
  bool complete = false;
  const bool short_motion = prescribed_.farthest() <= plane_motion_max * store_.model().mean_edge;
  TruncationKind kind = short_motion ? TruncationKind::planes : TruncationKind::rides;
  double distance_before = 0;
  double distance_two_before = 0;
  typename PrescribedMotion<T>::Misses lag;
  for (int pass = 0; good && !complete; ++pass) {
    if (pass > 0) good = approach(a, pass, report);
    if (!good) break;
    update_.cache_contacts(a.dt);
    complete = pass > 0 && resolve_again(a, report);
    good = complete || (collisions_failed(report) && clear_path(a, kind, complete, report));
    if (!good) break;
    report.clear_failure();
    clock_.mark(StageClock::resolved);
    take_part_way(watch);
    report.stages.resolve_collisions += clock_.between(StageClock::solved, StageClock::resolved);
    lag = prescribed_.misses();
    const bool stagnates =
        pass > 0 ? lag.distance > lag_left * distance_before
                 : lag.farther <= lag_least * contact_thickness(store_.scene().contact);
    if (lag.over_limit <= 1 &&
        (lag.distance <= lag_least * contact_thickness(store_.scene().contact) ||
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
  detection_.hold_normal_forces(0);
  if (good && lag.over_limit > 1) good = prescribed_.fail_by(lag, a.dt, report);
  return_to_start(a, good);
  if (!good) return false;
  report.compliant = std::max(report.compliant, lag.count);
  report.compliance_distance = std::max(report.compliance_distance, lag.distance);
  report.fallback_level = FallbackLevel::truncated;
  ++report.truncations;
  update_.accept(a.dt);
  return true;
}

template <class T>
void TruncatedStep<T>::grant() {
  approaches_left_ = approaches_of_step_max;
  truncated_collisions_left_ =
      std::max(collisions_per_vertex_least,
               collisions_per_vertex / (1 + store_.backoff.truncated)) *
      std::max<std::int64_t>(vertices_least, store_.model().cloth_vertex_count);
  publisher_->set_truncated_solves(0, approaches_left_);
}

/// Keeps the start of the truncated step: its parts take its place until it is over.
template <class T>
void TruncatedStep<T>::keep_start() {
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
bool TruncatedStep<T>::approach(const Attempt& a, int pass, StepReport& report) {
  if (stopped(store_.devices(), report)) return false;
  --approaches_left_;
  publisher_->set_truncated_solves(approaches_of_step_max - approaches_left_, approaches_left_);
  publisher_.enter(StepStage::contacts, report);
  detection_.hold_normal_forces(
      std::min(stiffness_factor_max, std::pow(stiffness_growth, static_cast<double>(pass))));
  const std::vector<Vec3<T>>& targets = truncated_.targets();
  for (int r = 0; r < store_.devices().size(); ++r)
    store_.devices()[r].compute().copy(motion_[static_cast<std::size_t>(r)].positions_t1.data(),
                                       targets.data(), targets.size() * sizeof(Vec3<T>));
  clock_.mark(StageClock::predicted);
  detection_.search(a.dt, true, report);
  clock_.mark(StageClock::contacts);
  const bool solved = solver_.solve_about_state(a, report);
  clock_.mark(StageClock::solved);
  sync_ranks(store_.devices());
  report.stages.contacts += clock_.between(StageClock::predicted, StageClock::contacts);
  report.stages.solve += clock_.between(StageClock::contacts, StageClock::solved);
  return solved;
}

/// Impact zones, with little work.
template <class T>
bool TruncatedStep<T>::resolve_again(const Attempt& a, StepReport& report) {
  resolver_.grant(ZoneBudget::of_part(store_.model().cloth_vertex_count));
  return resolver_.resolve(
      {.dt = a.dt, .h = a.h, .at_rest = a.at_rest, .must_stand = true, .may_solve_again = false},
      report);
}

/// Cuts the motion to positions_t1 off before it meets something.
/// @param complete set to whether there is nothing that it meets
template <class T>
bool TruncatedStep<T>::clear_path(const Attempt& a, TruncationKind kind, bool& complete,
                                  StepReport& report) {
  Queue& master = store_.devices()[0].compute();
  publisher_.enter(StepStage::truncation, report);
  prescribed_.place(store_.time + a.dt);  // zones may have moved these vertices
  truncated_.begin(download(master, store_.rank(0).positions),
                   download(master, motion_.front().positions_t1), prescribed_.fixed(), kind,
                   contact_thickness(store_.scene().contact));
  complete = true;
  bool later_round = false;
  int rebuilds = 0;
  int rounds = 0;
  while (true) {
    collisions_.clear();
    detection_.launch_continuous(later_round, false, report);
    const CollideCounts counts = detection_.collect(collisions_, later_round, false);
    if (stopped(store_.devices(), report)) return false;
    if (counts.not_finite > 0)
      return fail_not_finite(store_, motion_.front(), counts.not_finite, report);
    if (counts.out_of_bounds > 0) {
      // Ends move less far with every round, so boxes around the whole motion last.
      if (rebuilds++ > TruncatedMotion<T>::rounds_max)
        return fail(report, Failure::intersection, "vertices keep leaving their swept AABBs");
      ++report.rebuilds;
      detection_.extend_pairs(a.dt, report);
      continue;
    }
    report.ccd_tests += counts.ccd_tests;
    if (counts.collisions == 0 && !later_round) return true;
    if (counts.collisions > 0) {
      // Nothing moves after the last round, so what is left touches at the start of the step.
      if (rounds++ == TruncatedMotion<T>::rounds_max)
        return fail(report, Failure::intersection, "cloth touches at the start of the step",
                    place_of(store_, collisions_.front()));
      complete = false;
      report.impacts += counts.collisions;
      truncated_collisions_left_ -= counts.collisions;
      publisher_->set_round(report.zone_rounds, 0, counts.collisions);
      resolver_.apply(truncated_.shorten({collisions_.data(), collisions_.size()}), a.h);
    }
    // A later round tests only pairs of moved vertices. Motions are accepted once all pairs pass.
    later_round = counts.collisions > 0;
  }
}

/// The end of this part becomes the start of the next one.
template <class T>
void TruncatedStep<T>::take_part_way(const Watch& watch) {
  DeviceSet& devices = store_.devices();
  sync_ranks(devices);
  if (watch) watch(store_.rank(0).positions.span(), motion_.front().positions_t1.span());
  for (int r = 0; r < devices.size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    devices[r].compute().copy(state.positions.data(), m.positions_t1.data(),
                              m.positions_t1.size() * sizeof(Vec3<T>));
    std::swap(state.contacts, m.contacts);
  }
  store_.face_contacts = motion_.front().face_contacts;
}

/// The start of the step takes its place in the state again.
/// @param good the step stands: what its last part has left is its end
template <class T>
void TruncatedStep<T>::return_to_start(const Attempt& a, bool good) {
  DeviceSet& devices = store_.devices();
  for (int r = 0; r < devices.size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = devices[r].compute();
    auto& start = start_.ranks[static_cast<std::size_t>(r)];
    if (good) {
      std::swap(state.contacts, m.contacts);
      m.face_contacts = store_.face_contacts;
    }
    std::swap(state.positions, start.positions);
    std::swap(state.contacts, start.contacts);
    if (!good) continue;
    // No history of a multi-step integrator holds across it.
    queue.fill(m.moved_in_attempt.data(), 1, m.moved_in_attempt.size());
    launch(queue, IntegrateRate<T>{m.positions_t1.span(), m.base_positions.span(),
                                   static_cast<T>(a.h), m.velocities_t1.span()});
  }
  if (good) update_.remember_touched(Hardening::none);
  store_.face_contacts = start_.face_contacts;
  sync_ranks(devices);
}

template class TruncatedStep<float>;
template class TruncatedStep<double>;

}  // namespace weft
