#include "host/implicit/step.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "host/implicit/parallel/exchange.hpp"
#include "host/model/springs.hpp"
#include "weft/elements/contact.hpp"
#include "weft/kernels/assemble/contact_cache.hpp"
#include "weft/kernels/integrate/advance.hpp"
#include "weft/kernels/integrate/history.hpp"
#include "weft/kernels/integrate/prescribe.hpp"
#include "weft/kernels/integrate/rate.hpp"
#include "weft/kernels/respond/remember.hpp"

namespace weft {
namespace {

/// Bisections of a truncated step: shorter parts hardly help.
constexpr int truncated_bisections_max = 3;
/// Collisions that impact zones may look at in a step, per vertex of the cloth. Such a visit costs
/// a quarter of a row of the matrix in a product, and an ordinary step takes some hundred products:
/// so zones get some 15 times as much as the rest of a step.
constexpr std::int64_t zone_visits_per_vertex = 6'000;
/// After so many truncated steps in a row, impact zones will probably fail again and get no work,
/// except in one step in so many: zones that succeed get cloth out of a jam.
constexpr std::int32_t truncations_least = 8;
constexpr std::int32_t full_try_interval = 4;
/// [thicknesses] by which rotating obstacles may leave the planes of their contacts in an attempt.
/// With 1, cloth in a drum of 1,000 revolutions a minute still ends in truncated steps.
constexpr double turning_max = 0.5;
/// Edges by which heavily loaded contacts between cloths may slide in an attempt. Chosen in
/// docs/decisions/002-contacts.md.
constexpr double slide_max = 0.5;
/// Times in which cloth would fall by half of the thickness that the mean load of a contact takes
/// to follow its force. Stiffness that follows the force at once makes stacks swing ever more.
constexpr double load_falls = 10;
/// Share of that way in a step if nothing has a weight.
constexpr double weightless_load_share = 0.05;
/// Contacts harden after an attempt that met more impacts than this share of the cloth's vertices.
/// With fewer, fine cloth that only folds would be driven apart.
constexpr double jammed_share = 0.1;
/// Cloths of fewer vertices get as much as one of so many.
constexpr std::int64_t zone_vertices_least = 256;

/// Rotation from one placement to another: its axis, and as length the sine of its angle, or 1 if
/// that is more than a right angle.
Vec3<double> rotation_between(Transform from, Transform to) {
  for (Transform* t : {&from, &to}) {
    t->translate = {};
    t->scale = 1;
  }
  Vec3<double> axis{};
  double cosines = 0;
  for (int k = 0; k < 3; ++k) {
    Vec3<double> unit{};
    unit[k] = 1;
    const Vec3<double> a = apply(from, unit);
    const Vec3<double> b = apply(to, unit);
    axis += 0.5 * cross(a, b);
    cosines += dot(a, b);
  }
  const double sine = length(axis);
  return cosines < 1 && sine > 0 ? (1 / sine) * axis : axis;
}

template <class Part, class T, class Make>
std::vector<Part> make_ranks(Store<T>& store, Make make) {
  std::vector<Part> parts;
  for (int r = 0; r < store.devices().size(); ++r) parts.push_back(make(store, r));
  return parts;
}

template <class T>
std::vector<Buffer<T>> make_buffers(DeviceSet& devices) {
  std::vector<Buffer<T>> buffers;
  for (int r = 0; r < devices.size(); ++r) buffers.emplace_back(devices[r]);
  return buffers;
}

}  // namespace

template <class T>
ImplicitStep<T>::ImplicitStep(Store<T>& store, const ImplicitStep* before)
    : store_(store),
      geometry_(make_ranks<RankGeometry<T>>(store, make_geometry<T>)),
      motion_(make_ranks<RankMotion<T>>(store, make_motion<T>)),
      search_(store, geometry_, motion_,
              before != nullptr ? before->search_.hints() : DetectionHints{}),
      system_(store, geometry_, motion_),
      row_balance_(store.scene().solver.rebalance, store.devices().backend()),
      rank_targets_(make_buffers<MovedVertex<T>>(store.devices())),
      rank_moved_(make_buffers<MovedVertex<T>>(store.devices())),
      zones_(store, geometry_, motion_),
      rank_mismatch_(make_buffers<double>(store.devices())),
      rank_friction_(make_buffers<std::int64_t>(store.devices())),
      external_work_(store, geometry_),
      epoch_(store.epoch()),
      error_estimate_(store),
      clock_(store.devices()),
      nominal_step_(store.scene().time.step) {}

template <class T>
std::int64_t ImplicitStep<T>::zone_budget() const {
  return zone_visits_per_vertex *
         std::max<std::int64_t>(zone_vertices_least, store_.model().cloth_vertex_count);
}

template <class T>
void ImplicitStep<T>::grant_zone_visits(std::int64_t visits) {
  visits_left_ = visits_granted_ = visits;
  publish_zone_work();
}

template <class T>
void ImplicitStep<T>::publish_zone_work() {
  board_->set_zone_work(visits_left_ + visits_reserved_, visits_granted_);
}

/// Publishes that a stage begins.
template <class T>
void ImplicitStep<T>::enter(StepStage stage, const StepReport& report) {
  board_->enter(stage, truncating_ ? FallbackLevel::truncated : report.fallback_level);
}

template <class T>
void ImplicitStep<T>::publish_substep(const Attempt& a) {
  board_->set_substep(a.dt / step_length_, (store_.time - step_begin_) / step_length_);
}

template <class T>
void ImplicitStep<T>::advance(double dt, StepReport& report) {
  WEFT_ASSERT(epoch_ == store_.epoch());  // nothing here changes topology
  const bool automatic = store_.scene().time.automatic;
  rebalance(report);
  const auto allocations = [this] {
    std::int64_t count = 0;
    for (int r = 0; r < store_.devices().size(); ++r)
      count += store_.devices()[r].allocation_count();
    return count;
  };
  const Queue& queue = store_.devices()[0].compute();
  report.self_certified = store_.scene().contact.self;
  report.certificate_seconds -= search_.certificate_seconds();
  report.allocations -= allocations();
  report.synchronisations -= queue.sync_count();
  kept_ = false;
  step_begin_ = store_.time;
  step_length_ = dt;
  step_error_ = 0;
  if (automatic) nominal_step_ = dt;
  search_.set_nominal_step(nominal_step_);
  truncating_ = false;
  stretched_ = false;
  turning_acceleration_ = slide_speed_ = 0;
  work_ = 0;
  report.work.reset();
  const Backoff before = store_.backoff;
  Backoff backoff = before;
  backoff.stretched = std::max(0, before.stretched - 1);
  store_.backoff = backoff;
  const int bisections = store_.scene().contact.substep_bisections;
  const bool rarely =
      backoff.truncated >= truncations_least && backoff.truncated % full_try_interval != 0;
  grant_zone_visits(rarely ? 0 : zone_budget());
  bool good = advance_bisecting(dt, bisections, report);
  if (!good && collisions_failed(report)) {
    const bool attempted = !kept_;
    if (std::exchange(kept_, false)) store_.go_back();
    store_.backoff = backoff;
    step_error_ = 0;
    truncating_ = true;
    work_ = 0;
    grant_approaches();
    good =
        advance_truncating(dt, std::min(bisections, truncated_bisections_max), attempted, report);
  }
  if (good) {
    store_.backoff.truncated = report.truncations > 0 ? backoff.truncated + 1 : 0;
    if (stretched_) store_.backoff.stretched = Backoff::run_max;
    if (automatic) report.step_error = step_error_;
    // A motion that is cut off has no forces of its own. What tracks another run is pulled.
    if (!tracked_ && (report.truncations == 0 || !external_work_.any())) report.work = work_;
  } else {
    report.fallback_level = FallbackLevel::failed;
    if (kept_) store_.go_back();
    store_.backoff = before;
  }
  report.certificate_seconds += search_.certificate_seconds();
  report.balance += search_.take_balance();
  report.allocations += allocations();
  report.synchronisations += queue.sync_count();
}

template <class T>
bool ImplicitStep<T>::advance_bisecting(double dt, int bisections_left, StepReport& report) {
  const double end = store_.time + dt;
  Backoff& backoff = store_.backoff;
  const bool whole = bisections_left == store_.scene().contact.substep_bisections;
  if (whole && bisections_left > 0 && backoff.left > 0) {
    --backoff.left;
  } else if (bisections_left == 0 || !contacts_move_too_far(dt)) {
    // Bisections have not avoided the truncation of the step before, and do not part what has to
    // give way.
    if (bisections_left > 0 && backoff.truncated == 0 && !zones_.any_may_comply())
      visits_reserved_ = visits_left_ - visits_left_ / attempt_share;
    visits_left_ -= visits_reserved_;
    const bool good = attempt(begin(dt, bisections_left == 0), report);
    visits_left_ += std::exchange(visits_reserved_, 0);
    if (whole && good) backoff.left = backoff.run = 0;
    if (good) return true;
    if (bisections_left == 0 || report.failure == Failure::stopped) return false;
    if (collisions_failed(report) && visits_left_ <= 0) return false;
    if (whole && report.failure == Failure::not_converged) backoff.begin_run();
    ++report.retries;
  }
  // A step stands as a whole or not at all: a part of it would be no state to go on from.
  if (!std::exchange(kept_, true)) store_.keep();
  report.fallback_level = std::max(report.fallback_level, FallbackLevel::halved);
  report.clear_failure();
  if (!advance_bisecting(dt / 2, bisections_left - 1, report)) return false;
  if (!advance_bisecting(dt / 2, bisections_left - 1, report)) return false;
  store_.time = end;  // two halves must end where the whole would have, to the bit
  return true;
}

/// One step of length a.dt, in the order of P-Cloth figure 2.
template <class T>
bool ImplicitStep<T>::attempt(const Attempt& a, StepReport& report) {
  DeviceSet& devices = store_.devices();
  if (stopped(report)) return false;
  const int iterations_before = report.iterations;
  publish_substep(a);
  enter(StepStage::prediction, report);
  clock_.mark(StageClock::begin);
  prescribe(store_.time + a.dt);
  if (tracked_) tracked_->aim(store_.time + a.dt, fixed_);
  set_base(a);
  predict(a);
  clock_.mark(StageClock::predicted);
  enter(StepStage::contacts, report);
  search_.search(a.dt, search_every_step_, report);
  clock_.mark(StageClock::contacts);
  measure_turning(a);
  slide_speed_ = std::max(slide_speed_, search_.slide() / a.dt);
  if (!a.last_resort && contacts_move_too_far(a.dt)) {
    sync_ranks(devices);
    return false;
  }
  enter(StepStage::solve, report);
  const bool solved = solve(a, report);
  clock_.mark(StageClock::solved);
  const bool good = solved && !stopped(report) && resolve_collisions(a, report);
  report.self_certified = report.self_certified && !search_.lists_self();
  if (good) cache_contacts(a);
  if (good) remember_touched(hardens());
  if (good && tracked_) report_tracking(report);
  clock_.mark(StageClock::certified);
  if (devices.size() > 1) system_.ask_row_work();
  sync_ranks(devices);
  count_rows(report.iterations - iterations_before, report);
  report.stages.other += clock_.between(StageClock::begin, StageClock::predicted);
  report.stages.contacts += clock_.between(StageClock::predicted, StageClock::contacts);
  report.stages.solve += clock_.between(StageClock::contacts, StageClock::solved);
  report.stages.resolve_collisions += clock_.between(StageClock::solved, StageClock::certified);
  if (good && watch_) watch_(store_.rank(0).positions.span(), motion_.front().positions_t1.span());
  if (good) add_work(a, report);
  if (good) accept(a);
  return good;
}

template <class T>
typename ImplicitStep<T>::Attempt ImplicitStep<T>::begin(double dt, bool last_resort) {
  Attempt a{dt, dt, true, last_resort};
  if (store_.scene().integrator == Integrator::bdf2 && store_.previous_step > 0) {
    const double q = dt / store_.previous_step;
    a.h = dt * (1 + q) / (1 + 2 * q);
    a.at_rest = false;
  }
  return a;
}

/// Obstacles and pinned vertices to where they are at `time`.
template <class T>
void ImplicitStep<T>::prescribe(double time) {
  const Model& model = store_.model();
  const Scene& scene = store_.scene();
  DeviceSet& devices = store_.devices();
  const std::vector<unsigned char> fixed = fixed_vertices(scene, model, time);
  const bool fixed_changed = fixed != fixed_;
  if (fixed_changed) {
    fixed_ = fixed;
    system_.hold(fixed_);
  }
  set_springs(time);
  const VertexRun placed = place_obstacles(scene, model, time, placed_);
  targets_.clear();
  for (const auto& p : model.pinned)
    if (fixed_[static_cast<std::size_t>(p.vertex)] != 0)
      targets_.push_back({p.vertex, vec_cast<T>(pinned_position(scene, p, time, placed_))});
  const auto first = static_cast<std::size_t>(placed.first);
  const auto last = static_cast<std::size_t>(placed.last);
  placed_rounded_.resize(placed_.size());
  for (std::size_t i = first; i < last; ++i) placed_rounded_[i] = vec_cast<T>(placed_[i]);
  const auto cloth = static_cast<std::size_t>(model.cloth_vertex_count);
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Queue& queue = devices[r].compute();
    if (fixed_changed) queue.copy(geometry_[n].fixed.data(), fixed_.data(), fixed_.size());
    queue.copy(motion_[n].positions_t1.data() + cloth, placed_rounded_.data(),
               placed_rounded_.size() * sizeof(Vec3<T>));
    rank_targets_[n].resize(targets_.size());
    queue.copy(rank_targets_[n].data(), targets_.data(), targets_.size() * sizeof(MovedVertex<T>));
    launch(queue, IntegratePrescribe<T>{rank_targets_[n].span(), motion_[n].positions_t1.span()});
  }
}

/// Measures how fast rotating obstacles leave the planes of their contacts, which have been found.
template <class T>
void ImplicitStep<T>::measure_turning(const Attempt& a) {
  const Scene& scene = store_.scene();
  const Model& model = store_.model();
  std::vector<Vec3<double>> turned;
  bool any = false;
  for (const Obstacle& obstacle : scene.obstacles) {
    turned.push_back(obstacle.motion.empty()
                         ? Vec3<double>{}
                         : rotation_between(transform_at(obstacle.motion, store_.time),
                                            transform_at(obstacle.motion, store_.time + a.dt)));
    any = any || length_sq(turned.back()) > 0;
  }
  const Span<const Contact<T>> all = search_.contacts(0);
  if (!any || all.empty()) return;
  place_obstacles(scene, model, store_.time, placed_before_);
  // Contacts need not be fetched if no vertex of an obstacle leaves its start so far.
  double bound = 0;
  for (std::size_t o = 0; o < turned.size(); ++o) {
    const double sine = length(turned[o]);
    if (sine == 0) continue;
    const auto first = static_cast<std::size_t>(model.obstacle_offset[o]);
    const auto last = static_cast<std::size_t>(model.obstacle_offset[o + 1]);
    for (std::size_t i = first; i < last; ++i)
      bound = std::max(bound, length(placed_[i] - placed_before_[i]) * sine / 2);
  }
  if (bound <= turning_max * scene.contact.thickness) return;
  std::vector<Contact<T>> contacts(all.size());
  Queue& master = store_.devices()[0].compute();
  master.copy(contacts.data(), all.data(), all.size() * sizeof(Contact<T>));
  master.sync();
  for (const Contact<T>& c : contacts) {
    const Vec3<double> n = vec_cast<double>(c.n);
    Vec3<double> moved{};
    Index last = -1;
    for (int j = 0; j < 4; ++j) {
      if (c.v[j] < model.cloth_vertex_count) continue;
      last = c.v[j] - model.cloth_vertex_count;
      const auto i = static_cast<std::size_t>(last);
      moved += static_cast<double>(c.w[j]) * (placed_[i] - placed_before_[i]);
    }
    if (last < 0) continue;
    const auto next =
        std::upper_bound(model.obstacle_offset.begin(), model.obstacle_offset.end(), last);
    const auto obstacle = static_cast<std::size_t>(next - model.obstacle_offset.begin() - 1);
    turning_acceleration_ = std::max(
        turning_acceleration_,
        length(tangential(moved, n)) * length(tangential(turned[obstacle], n)) / (a.dt * a.dt));
  }
}

/// Whether obstacles would leave the planes of their contacts too far, or what bears much would
/// slide past too many of the triangles that contacts were found on.
template <class T>
bool ImplicitStep<T>::contacts_move_too_far(double dt) const {
  return turning_acceleration_ * dt * dt / 2 > turning_max * store_.scene().contact.thickness ||
         slide_speed_ * dt > slide_max;
}

/// The springs of handles and seams as they are at `time`.
template <class T>
void ImplicitStep<T>::set_springs(double time) {
  std::vector<Spring<T>> springs;
  seams_pull_ = false;
  for (const Spring<double>& s : springs_at(store_.scene(), store_.model(), time)) {
    springs.push_back({{s.v[0], s.v[1]},
                       vec_cast<T>(s.anchor),
                       static_cast<T>(s.stiffness),
                       static_cast<T>(s.rest)});
    seams_pull_ = seams_pull_ || s.v[1] >= 0;
  }
  search_.let_seams_close(seams_pull_);
  system_.set_springs(springs);
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
  }
}

/// Where everything would end with nothing but gravity to change its velocity. Gravity is in it so
/// that what rests on something is seen to press on it; for that the thickness is far enough, and
/// steps as long as those of statics would lead far away.
template <class T>
void ImplicitStep<T>::predict(const Attempt& a) {
  const Vec3<double>& gravity = store_.scene().gravity;
  const double fall = length(gravity) * a.dt * a.dt;
  const double share = std::min(1.0, store_.scene().contact.thickness / std::max(fall, 1e-300));
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

/// Own rows of the new velocities to all ranks, and positions from them.
template <class T>
void ImplicitStep<T>::spread_solution(const Attempt& a) {
  DeviceSet& devices = store_.devices();
  all_gather_rows<Vec3<T>>(devices, store_.partition(), [this](int r) {
    return motion_[static_cast<std::size_t>(r)].velocities_t1.span();
  });
  for (int r = 0; r < devices.size(); ++r) {
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    launch(devices[r].compute(),
           IntegrateAdvance<T>{m.base_positions.span(), m.velocities_t1.span(),
                               geometry_[static_cast<std::size_t>(r)].fixed.span(),
                               static_cast<T>(a.h), m.positions_t1.span()});
  }
}

/// What the step's contacts leave to the next one.
template <class T>
void ImplicitStep<T>::cache_contacts(const Attempt& a) {
  const double gravity = length(store_.scene().gravity);
  const double load_time = load_falls * std::sqrt(store_.scene().contact.thickness / gravity);
  const double load_share = gravity > 0 ? std::min(1.0, a.dt / load_time) : weightless_load_share;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const Span<const Contact<T>> contacts = search_.contacts(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    m.contacts.grow(contacts.size());
    m.contacts.resize(contacts.size());
    launch(store_.devices()[r].compute(),
           AssembleContactCache<T>{contacts, m.positions_t1.span(), store_.rank(r).positions.span(),
                                   static_cast<T>(load_share), m.contacts.span()});
  }
}

/// Whether contacts of the vertices that zones have moved in this attempt are to harden: seams that
/// pull would be held open.
template <class T>
bool ImplicitStep<T>::hardens() const {
  return !seams_pull_ && static_cast<double>(collisions_.size()) >
                             jammed_share * static_cast<double>(store_.model().cloth_vertex_count);
}

/// Updates what the state knows of vertices that zones move.
/// @pre the attempt stands
template <class T>
void ImplicitStep<T>::remember_touched(bool raise) {
  for (int r = 0; r < store_.devices().size(); ++r)
    launch(store_.devices()[r].compute(),
           RespondRemember{motion_[static_cast<std::size_t>(r)].touched.span(), raise,
                           store_.rank(r).touched.span()});
}

/// Adds what was given to the cloth in an attempt that stands.
template <class T>
void ImplicitStep<T>::add_work(const Attempt& a, const StepReport& report) {
  const bool zones = !collisions_.empty();
  const RankMotion<T>& m = motion_.front();
  const double residual = at_.translated ? 0 : report.newton_residual * first_reference_;
  work_ += external_work_.of({a.dt, at_.translated, residual, &fixed_, search_.contacts(0),
                              zones ? zones_.free_positions(0) : m.positions_t1.span(),
                              zones ? zones_.free_velocities(0) : m.velocities_t1.span(),
                              m.positions_t1.span(), m.velocities_t1.span(), &collisions_});
}

/// The end of the step becomes the state.
template <class T>
void ImplicitStep<T>::accept(const Attempt& a) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    std::swap(state.previous_positions, state.positions);
    std::swap(state.positions, m.positions_t1);
    std::swap(state.previous_velocities, state.velocities);
    std::swap(state.velocities, m.velocities_t1);
    std::swap(state.contacts, m.contacts);
  }
  store_.face_contacts = search_.face_contacts();
  store_.time += a.dt;
  store_.previous_step = a.dt;
  if (store_.scene().time.automatic) step_error_ += error_estimate_.measure(geometry_.front());
}

/// What moving cloth vertices along straight lines from the state would run into, tied ones and
/// all.
template <class T>
std::vector<Collision> ImplicitStep<T>::collisions_on_the_way(
    const std::vector<MovedVertex<T>>& moves) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Queue& queue = store_.devices()[r].compute();
    Buffer<Vec3<T>>& end = motion_[n].positions_t1;
    queue.copy(end.data(), store_.rank(r).positions.data(), end.size() * sizeof(Vec3<T>));
    rank_moved_[n].resize(moves.size());
    queue.copy(rank_moved_[n].data(), moves.data(), moves.size() * sizeof(MovedVertex<T>));
    launch(queue, IntegratePrescribe<T>{rank_moved_[n].span(), end.span()});
  }
  StepReport unused;
  search_.search(store_.scene().time.step, true, unused);
  search_.launch_continuous(false, false, unused);
  std::vector<Collision> collisions;
  search_.collect(collisions, false, false);
  return collisions;
}

/// Whether somebody has asked for an end. What has been computed since may be anything.
template <class T>
bool ImplicitStep<T>::stopped(StepReport& report) {
  return store_.devices().stop_requested() && !fail(report, Failure::stopped, "");
}

template <class T>
bool ImplicitStep<T>::fail(StepReport& report, Failure failure, const std::string& detail,
                           const std::optional<Vec3<double>>& place) {
  report.failure = failure;
  report.failure_detail = detail;
  report.failure_place = place;
  return false;
}

template class ImplicitStep<float>;
template class ImplicitStep<double>;

}  // namespace weft
