#include "host/implicit/step.hpp"

#include <algorithm>
#include <utility>

#include "host/implicit/parallel/exchange.hpp"
#include "weft/error.hpp"
#include "weft/kernels/integrate/advance.hpp"
#include "weft/kernels/integrate/apply_forces.hpp"
#include "weft/kernels/integrate/history.hpp"

namespace weft {
namespace {

/// Bisections of a truncated step: shorter parts hardly help.
constexpr int truncated_bisections_max = 3;
/// After so many truncated steps in a row, impact zones will probably fail again and get no work,
/// except in one step in so many: zones that succeed get cloth out of a jam.
constexpr std::int32_t truncations_least = 8;
constexpr std::int32_t full_try_interval = 4;
/// Contacts harden after an attempt that met more impacts than this share of the cloth's vertices.
/// With fewer, fine cloth that only folds would be driven apart.
constexpr double jammed_share = 0.1;
/// The same for contacts that are crushed.
constexpr double crushed_share = 0.01;

template <class Part, class T, class Make>
std::vector<Part> make_ranks(Store<T>& store, Make make) {
  std::vector<Part> parts;
  for (int r = 0; r < store.devices().size(); ++r) parts.push_back(make(store, r));
  return parts;
}

}  // namespace

template <class T>
ImplicitStep<T>::ImplicitStep(Store<T>& store, const ImplicitStep* before)
    : store_(store),
      geometry_(make_geometry(store)),
      motion_(make_ranks<RankMotion<T>>(store, make_motion<T>)),
      clock_(store.devices()),
      detection_(store, geometry_, motion_,
                 before != nullptr ? before->detection_.hints() : DetectionHints{}),
      system_(store, geometry_, motion_),
      rows_(store, geometry_, system_),
      solver_(store, geometry_, motion_, detection_, system_, clock_, publisher_),
      prescribed_(store, geometry_, motion_, system_),
      motion_limit_(store, detection_),
      resolver_(store, geometry_, motion_, detection_, system_, solver_, prescribed_, clock_,
                publisher_),
      update_(store, geometry_, motion_, detection_),
      truncated_(store, motion_, detection_, solver_, prescribed_, resolver_, update_, clock_,
                 publisher_),
      external_work_(store, geometry_),
      epoch_(store.epoch()) {}

template <class T>
void ImplicitStep<T>::advance(double dt, StepReport& report) {
  WEFT_ASSERT(epoch_ == store_.epoch());  // nothing here changes topology
  const bool automatic = store_.scene().time.automatic;
  rows_.rebalance(report);
  report.self_certified = store_.scene().contact.self;
  const Tally start = tally();
  kept_ = false;
  step_begin_ = store_.time;
  step_length_ = dt;
  const double nominal_step = automatic ? dt : store_.scene().time.step;
  detection_.set_nominal_step(nominal_step);
  resolver_.begin_step(nominal_step);
  update_.begin_step();
  motion_limit_.begin_step();
  solver_.set_truncating(false);
  publisher_.set_truncating(false);
  work_ = 0;
  report.work.reset();
  const Backoff before = store_.backoff;
  Backoff backoff = before;
  backoff.stretched = std::max(0, before.stretched - 1);
  store_.backoff = backoff;
  const int bisections = store_.scene().contact.substep_bisections;
  const bool rarely =
      backoff.truncated >= truncations_least && backoff.truncated % full_try_interval != 0;
  resolver_.grant(rarely ? 0 : ZoneBudget::of_step(store_.model().cloth_vertex_count));
  const std::optional<Fallback> next = advance_bisecting(dt, bisections, report);
  bool good = !next;
  if (next == Fallback::truncate) {
    const bool attempted = !kept_;
    if (std::exchange(kept_, false)) store_.go_back();
    store_.backoff = backoff;
    update_.begin_step();
    solver_.set_truncating(true);
    publisher_.set_truncating(true);
    work_ = 0;
    truncated_.grant();
    good =
        advance_truncating(dt, std::min(bisections, truncated_bisections_max), attempted, report);
  }
  if (good) {
    store_.backoff.truncated = report.truncations > 0 ? backoff.truncated + 1 : 0;
    if (resolver_.stretched_at_last()) store_.backoff.stretched = Backoff::stretched_max;
    if (automatic) report.step_error = update_.step_error();
    // A motion that is cut off has no forces of its own. What tracks another run is pulled.
    if (!tracked_ && (report.truncations == 0 || !external_work_.any())) report.work = work_;
  } else {
    report.fallback_level = FallbackLevel::failed;
    if (kept_) store_.go_back();
    store_.backoff = before;
  }
  report.balance += detection_.take_balance();
  const Tally end = tally();
  report.certificate_seconds += end.certificate_seconds - start.certificate_seconds;
  report.allocations += end.allocations - start.allocations;
  report.synchronisations += end.synchronisations - start.synchronisations;
}

template <class T>
std::optional<Fallback> ImplicitStep<T>::advance_bisecting(double dt, int bisections_left,
                                                           StepReport& report) {
  const double end = store_.time + dt;
  Backoff& backoff = store_.backoff;
  const bool whole = bisections_left == store_.scene().contact.substep_bisections;
  if (whole && bisections_left > 0 && backoff.left > 0) {
    --backoff.left;
  } else if (bisections_left == 0 || !motion_limit_.exceeded_in(dt)) {
    // Bisections have not avoided the truncation of the step before, and do not part what has to
    // give way.
    if (bisections_left > 0 && backoff.truncated == 0 && !resolver_.any_may_comply())
      resolver_.budget().reserve();
    const bool good = attempt(make_attempt(dt, bisections_left == 0, whole), report);
    resolver_.budget().release();
    if (whole && good) backoff.left = backoff.run = 0;
    if (good) return {};
    const Fallback next = after_failure(report, bisections_left, resolver_.budget().left());
    if (next != Fallback::halve) return next;
    if (whole && report.failure == Failure::not_converged) backoff.begin_run();
    ++report.retries;
  }
  // A step stands as a whole or not at all: a part of it would be no state to go on from.
  if (!std::exchange(kept_, true)) store_.keep();
  report.fallback_level = std::max(report.fallback_level, FallbackLevel::halved);
  report.clear_failure();
  for (int half = 0; half < 2; ++half)
    if (const auto next = advance_bisecting(dt / 2, bisections_left - 1, report)) return next;
  store_.time = end;  // two halves must end where the whole would have, to the bit
  return {};
}

/// The step in one piece if prescribed vertices can keep to their limits, else in halves.
/// @param attempted the latest attempt was at this very step, and failed
template <class T>
bool ImplicitStep<T>::advance_truncating(double dt, int bisections_left, bool attempted,
                                         StepReport& report) {
  const double end = store_.time + dt;
  const Attempt a = make_attempt(dt, true);
  const bool in_one = bisections_left == 0 || !motion_limit_.exceeded_in(dt);
  if (in_one && !attempted) {
    report.clear_failure();
    resolver_.grant(ZoneBudget::of_part(store_.model().cloth_vertex_count));
    if (attempt(a, report)) return true;
  }
  if (in_one && collisions_failed(report) &&
      truncated_.advance(a, bisections_left > 0, watch_, report))
    return true;
  if (report.failure == Failure::stopped || bisections_left == 0 || !truncated_.may_approach())
    return false;
  ++report.retries;
  if (!std::exchange(kept_, true)) store_.keep();
  if (!advance_truncating(dt / 2, bisections_left - 1, false, report)) return false;
  if (!advance_truncating(dt / 2, bisections_left - 1, false, report)) return false;
  store_.time = end;  // two halves must end where the whole would have, to the bit
  return true;
}

/// One step of length a.dt. Its stages are the rows of the table in ARCHITECTURE.md.
template <class T>
bool ImplicitStep<T>::attempt(const Attempt& a, StepReport& report) {
  DeviceSet& devices = store_.devices();
  if (stopped(devices, report)) return false;
  const int iterations_before = report.iterations;
  publisher_->set_substep(a.dt / step_length_, (store_.time - step_begin_) / step_length_);
  publisher_.enter(StepStage::prediction, report);
  clock_.mark(StageClock::begin);
  prescribed_.place(store_.time + a.dt);
  solver_.set_springs(store_.time + a.dt, a.dt);
  if (tracked_) tracked_->aim(store_.time + a.dt, prescribed_.fixed());
  set_base(a);
  predict(a);
  clock_.mark(StageClock::predicted);
  publisher_.enter(StepStage::contacts, report);
  detection_.search(a.dt, search_every_step_, report);
  clock_.mark(StageClock::contacts);
  motion_limit_.measure(a.dt, prescribed_.placed());
  const bool within_limit =
      a.must_stand || !motion_limit_.exceeded_in(a.dt) || fail(report, Failure::contact_motion, "");
  publisher_.enter(StepStage::solve, report);
  const bool solved = within_limit && solver_.solve(a, report);
  clock_.mark(StageClock::solved);
  const bool good = solved && !stopped(devices, report) && resolver_.resolve(a, report);
  report.self_certified = report.self_certified && !detection_.lists_self();
  if (good) update_.cache_contacts(a.dt);
  if (good) update_.remember_touched(hardening(a));
  if (good && tracked_) report_tracking(report);
  clock_.mark(StageClock::resolved);
  if (devices.size() > 1) system_.ask_row_work();
  sync_ranks(devices);
  rows_.count(report.iterations - iterations_before, report);
  report.stages.other += clock_.between(StageClock::begin, StageClock::predicted);
  report.stages.contacts += clock_.between(StageClock::predicted, StageClock::contacts);
  report.stages.solve += clock_.between(StageClock::contacts, StageClock::solved);
  report.stages.resolve_collisions += clock_.between(StageClock::solved, StageClock::resolved);
  if (good && watch_) watch_(store_.rank(0).positions.span(), motion_.front().positions_t1.span());
  if (good) add_work(a, report);
  if (good) update_.accept(a.dt);
  return good;
}

template <class T>
Attempt ImplicitStep<T>::make_attempt(double dt, bool must_stand, bool whole) const {
  Attempt a{.dt = dt, .h = dt, .at_rest = true, .must_stand = must_stand, .whole = whole};
  if (store_.scene().integrator == Integrator::bdf2 && store_.previous_step > 0) {
    const double q = dt / store_.previous_step;
    a.h = dt * (1 + q) / (1 + 2 * q);
    a.at_rest = false;
  }
  return a;
}

/// The state that the integrator's formula starts from: x~ and v~.
template <class T>
void ImplicitStep<T>::set_base(const Attempt& a) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    Queue& queue = store_.devices()[r].compute();
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    const std::size_t bytes = m.base_positions.size() * sizeof(Vec3<T>);
    if (a.at_rest) {
      queue.copy(m.base_positions.data(), state.positions.data(), bytes);
      queue.copy(m.base_velocities.data(), state.velocities.data(), bytes);
    } else {
      launch(queue,
             IntegrateHistory<T>{state.positions.span(), state.velocities.span(),
                                 state.previous_positions.span(), state.previous_velocities.span(),
                                 state.touched.span(), static_cast<T>(a.dt / store_.previous_step),
                                 static_cast<T>(store_.previous_step), m.base_positions.span(),
                                 m.base_velocities.span()});
    }
    if (!store_.accelerations().empty())
      launch(queue, IntegrateApplyForces<T>{state.accelerations.span(), static_cast<T>(a.h),
                                            m.base_velocities.span()});
  }
}

/// Where everything would end with nothing but gravity to change its velocity. Gravity is in it so
/// that what rests on something is seen to press on it; for that the thickness is far enough, and
/// steps as long as those of statics would lead far away.
template <class T>
void ImplicitStep<T>::predict(const Attempt& a) {
  const Vec3<double>& gravity = store_.scene().gravity;
  const double fall = length(gravity) * a.dt * a.dt;
  const double share =
      std::min(1.0, contact_thickness(store_.scene().contact) / std::max(fall, 1e-300));
  for (int r = 0; r < store_.devices().size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    launch(store_.devices()[r].compute(),
           IntegrateAdvance<T>{state.positions.span(), state.velocities.span(),
                               geometry_[static_cast<std::size_t>(r)].fixed.span(),
                               static_cast<T>(a.dt), m.positions_t1.span(),
                               vec_cast<T>(share * a.dt * gravity)});
  }
}

/// Which contacts this attempt hardens: seams that pull would be held open.
template <class T>
Hardening ImplicitStep<T>::hardening(const Attempt& a) const {
  if (solver_.seams_pull() || tracked_) return Hardening::none;
  const auto impacts = static_cast<double>(resolver_.collisions().size());
  const auto vertices = static_cast<double>(store_.model().cloth_vertex_count);
  if (impacts > jammed_share * vertices) return Hardening::all;
  if (!a.whole) return Hardening::none;
  return impacts > crushed_share * vertices ? Hardening::crushed : Hardening::jammed;
}

/// Adds the external work of an accepted attempt.
template <class T>
void ImplicitStep<T>::add_work(const Attempt& a, const StepReport& report) {
  const RankMotion<T>& m = motion_.front();
  work_ += external_work_.of(
      {a.dt, solver_.linear_about(), solver_.residual(report), &prescribed_.fixed(),
       detection_.contacts(0), resolver_.solved_positions(0), resolver_.solved_velocities(0),
       m.positions_t1.span(), m.velocities_t1.span(), &resolver_.collisions()});
}

template <class T>
void ImplicitStep<T>::track(std::shared_ptr<const Tracking> tracking) {
  const DeviceSet& devices = store_.devices();
  if (tracking && (devices.backend() != Backend::host || devices.size() != 1))
    throw DeviceError("tracking constraints are there for one rank of the host only; use cpu:1");
  system_.track(nullptr);
  tracked_.reset();
  tracking_ = std::move(tracking);
  resolver_.set_pulled(tracking_ != nullptr);
  if (!tracking_) return;
  tracked_ = std::make_unique<TrackedSystem>(store_.model(), *tracking_);
  system_.track(tracked_.get());
}

/// By how much contact has kept averages off their target. Rank 0 has been waited for.
template <class T>
void ImplicitStep<T>::report_tracking(StepReport& report) {
  Queue& queue = store_.devices()[0].compute();
  const double error = tracked_->error(download(queue, motion_.front().positions_t1));
  report.tracking_error = std::max(report.tracking_error, error);
}

template <class T>
bool ImplicitStep<T>::displace(const std::vector<Vec3<T>>& places, double time,
                               StepReport& report) {
  DeviceSet& devices = store_.devices();
  const double dt = store_.scene().time.step;
  const Attempt a{.dt = dt, .h = dt, .at_rest = true, .must_stand = true, .may_solve_again = false};
  resolver_.grant(ZoneBudget::of_step(store_.model().cloth_vertex_count));
  for (int r = 0; r < devices.size(); ++r) {
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = devices[r].compute();
    queue.copy(m.positions_t1.data(), places.data(), places.size() * sizeof(Vec3<T>));
    queue.copy(m.velocities_t1.data(), store_.rank(r).velocities.data(),
               m.velocities_t1.size() * sizeof(Vec3<T>));
  }
  prescribed_.place(time);
  solver_.set_springs(time, dt);
  set_base(a);
  detection_.search(dt, true, report);
  const bool good = resolver_.resolve(a, report);
  sync_ranks(devices);
  if (!good) return false;
  for (int r = 0; r < devices.size(); ++r)
    std::swap(store_.rank(r).positions, motion_[static_cast<std::size_t>(r)].positions_t1);
  store_.time = time;
  return true;
}

template <class T>
typename ImplicitStep<T>::Tally ImplicitStep<T>::tally() const {
  Tally tally{detection_.certificate_seconds(), 0, store_.devices()[0].compute().sync_count()};
  for (int r = 0; r < store_.devices().size(); ++r)
    tally.allocations += store_.devices()[r].allocation_count();
  return tally;
}

template class ImplicitStep<float>;
template class ImplicitStep<double>;

}  // namespace weft
