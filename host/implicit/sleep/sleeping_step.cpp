#include "host/implicit/sleep/sleeping_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/exec/host_device.hpp"
#include "host/geometry/aabb.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/model/springs.hpp"
#include "host/scene/frame_steps.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// What a position is rounded by and a vertex at rest may go to and fro, in epsilon of the largest
/// coordinate.
constexpr double grain_epsilons = 4;
/// Vertices that oscillate forever may move by this much more in a window than in the one before.
constexpr double growth_max = 1.01;
/// Sleepers are this many thicknesses away from what is awake: contacts are looked for to one of
/// them, and each of two surfaces is predicted to move by gravity by half of another at most.
constexpr double reach_thicknesses = 2;

/// Marks the pieces that a triangle on its way from x0 to x1 may come near.
template <class T>
void look_at(const Tri& t, Span<const Vec3<T>> x0, Span<const Vec3<T>> x1, const RestBoxes& boxes,
             std::vector<unsigned char>& near) {
  Aabb box;
  for (const Index v : t.v)
    for (const Span<const Vec3<T>>& x : {x0, x1}) box.include(vec_cast<double>(x[at(v)]));
  boxes.mark(box.lo, box.hi, near);
}

/// Marks what any triangle may come near that `awake(t)` says of cloth, and that moves of
/// obstacles.
template <class T, class Awake>
void look_at_all(const Model& model, Awake awake, Span<const Vec3<T>> x0, Span<const Vec3<T>> x1,
                 const RestBoxes& boxes, std::vector<unsigned char>& near) {
  const auto moves = [&](const Tri& t) {
    return std::any_of(t.v, t.v + 3,
                       [&](Index v) { return !(length_sq(x1[at(v)] - x0[at(v)]) == T(0)); });
  };
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    const Tri& tri = model.triangles[t];
    if (static_cast<Index>(t) < model.cloth_triangle_count ? awake(tri) : moves(tri))
      look_at(tri, x0, x1, boxes, near);
  }
}

bool same(const Spring<double>& a, const Spring<double>& b) {
  return a.v[0] == b.v[0] && a.v[1] == b.v[1] && length_sq(a.anchor - b.anchor) == 0 &&
         a.stiffness == b.stiffness && a.rest == b.rest && a.along == b.along;
}

/// Vertices whose springs are not the same in two lists, with everything a spring may do on the
/// way.
std::vector<Index> changed(const std::vector<Spring<double>>& before,
                           const std::vector<Spring<double>>& after) {
  std::vector<Index> result;
  const bool as_many = before.size() == after.size();
  const auto add = [&](const Spring<double>& s) {
    result.push_back(s.v[0]);
    if (s.v[1] >= 0) result.push_back(s.v[1]);
  };
  for (std::size_t n = 0; n < before.size(); ++n)
    if (!as_many || !same(before[n], after[n])) add(before[n]);
  for (std::size_t n = 0; n < after.size(); ++n)
    if (!as_many || !same(before[n], after[n])) add(after[n]);
  return result;
}

}  // namespace

template <class T>
SleepingStep<T>::SleepingStep(Store<T>& store, ImplicitStep<T>& whole)
    : store_(store),
      whole_(whole),
      component_of_(cloth_components(store.model())),
      open_seams_(any_seam_open(store.scene(), store.model())) {
  const Scene& scene = store.scene();
  if (store.devices().backend() != Backend::host)
    throw DeviceError(
        "method.implicit.sleep_distance is for CPU threads only; use --device cpu, or 0");
  for (const Index p : component_of_) component_count_ = std::max(component_count_, at(p) + 1);
  window_ = std::max<std::int64_t>(
      1, std::llround(std::min(1e9, scene.implicit.sleep_window / frame_step_length(scene.time))));
  steps_ = std::int64_t{frame_steps(scene.time)} * scene.time.frames;
}

template <class T>
void SleepingStep<T>::advance(double dt, StepReport& report) {
  take_state();
  laid_down_ = false;
  if (store_.step_number % window_ == 0 && !open_seams_) close_window();
  const double end = store_.time + dt;
  if (any_sleeps()) {
    place_obstacles(store_.scene(), store_.model(), end, placed_);
    wake_pulled(end, report);
    wake_approached(dt, report);
    lay_down(report);
  }
  while (any_sleeps() && !advance_awake(dt, report)) {
    // Something came near a sleeper, which is awake now. What that took stays in the counts.
    ++report.sleep.redone;
    report.clear_failure();
    report.fallback_level = FallbackLevel::whole;
    report.compliant = 0;
    report.compliance_distance = 0;
    wake_approached(dt, report);
  }
  if (!any_sleeps()) {
    awake_.reset();
    whole_.advance(dt, report);
  }
  note_excursions();
  report_sleep(report);
}

template <class T>
bool SleepingStep<T>::any_sleeps() const {
  const auto& pieces = store_.sleep.pieces;
  return std::any_of(pieces.begin(), pieces.end(),
                     [](const SleepComponent& p) { return p.since >= 0; });
}

template <class T>
SleepCauses SleepingStep<T>::causes() const {
  const Scene& s = store_.scene();
  return {s.gravity, s.wind.velocity, s.wind.density, s.wind.drag, contact_thickness(s.contact),
          window_};
}

/// What is off at the end of step `to_step` for having slept since. [m]
template <class T>
double SleepingStep<T>::departure(const SleepComponent& piece, std::int64_t to_step) const {
  const double windows = static_cast<double>(to_step - piece.since) / static_cast<double>(window_);
  return piece.jitter + piece.drift * windows + piece.bend * windows * windows / 2;
}

/// The step that the bound is for: the run's last, or the next one if that is later.
template <class T>
std::int64_t SleepingStep<T>::last_step() const {
  return std::max(steps_, store_.step_number + 1);
}

/// Notices a state that is not what the last step left: one that was read, or that of the start.
template <class T>
void SleepingStep<T>::take_state() {
  if (restores_ == store_.restores()) return;
  restores_ = store_.restores();
  awake_.reset();
  SleepState<T>& state = store_.sleep;
  if (state.pieces.size() != component_count_ || !(state.causes == causes())) {
    // What moved how far is known only of what is the case now.
    state.pieces.resize(component_count_);
    for (SleepComponent& p : state.pieces) {
      if (p.since >= 0) p.spent += departure(p, store_.step_number);
      const double spent = p.spent;
      p = {};
      p.spent = spent;
    }
    state.causes = causes();
    for (auto& mark : state.marks)
      mark.assign(positions().begin(), positions().begin() + store_.model().cloth_vertex_count);
  }
  if (any_sleeps()) make_boxes();
}

/// [m] Where a vertex of cloth was in the last two steps.
template <class T>
Vec3<double> SleepingStep<T>::mean_of_two(std::size_t vertex) const {
  const RankState<T>& state = store_.rank(0);
  return 0.5 * (vec_cast<double>(state.positions.data()[vertex]) +
                vec_cast<double>(state.previous_positions.data()[vertex]));
}

/// Lets pieces fall asleep that have hardly moved, and begins another window.
template <class T>
void SleepingStep<T>::close_window() {
  struct Moved {
    double drift = 0, bend = 0, largest = 0;
  };
  SleepState<T>& state = store_.sleep;
  std::vector<Moved> motion(component_count_);
  std::vector<Vec3<T>> marks(component_of_.size());
  for (std::size_t v = 0; v < component_of_.size(); ++v) {
    Moved& m = motion[at(component_of_[v])];
    const Vec3<double> now = mean_of_two(v);
    const Vec3<double> step = now - vec_cast<double>(state.marks[0][v]);
    const Vec3<double> before =
        vec_cast<double>(state.marks[0][v]) - vec_cast<double>(state.marks[1][v]);
    m.drift = std::max(m.drift, length(step));
    m.bend = std::max(m.bend, length(step - before));
    for (int c = 0; c < 3; ++c) m.largest = std::max(m.largest, std::abs(now[c]));
    marks[v] = vec_cast<T>(now);
  }
  bool any = false;
  for (std::size_t p = 0; p < component_count_; ++p) {
    SleepComponent& piece = state.pieces[p];
    if (piece.since >= 0) continue;
    SleepComponent asleep = piece;
    asleep.before = piece.excursion;
    asleep.excursion = 0;
    asleep.jitter = piece.excursion;
    asleep.drift = motion[p].drift;
    asleep.bend = motion[p].bend;
    asleep.since = store_.step_number;
    const double grain =
        grain_epsilons * static_cast<double>(std::numeric_limits<T>::epsilon()) * motion[p].largest;
    const bool slows = std::isfinite(piece.before) &&
                       piece.excursion <= std::max(growth_max * piece.before, grain);
    const bool fits =
        piece.spent + departure(asleep, last_step()) <= store_.scene().implicit.sleep_distance;
    piece.before = piece.excursion;
    piece.excursion = 0;
    if (!slows || !fits) continue;
    piece = asleep;
    any = true;
  }
  state.marks[1] = std::move(state.marks[0]);
  state.marks[0] = std::move(marks);
  if (any) make_boxes();
}

template <class T>
void SleepingStep<T>::wake(std::size_t number, StepReport& report) {
  SleepComponent& piece = store_.sleep.pieces[number];
  if (piece.since < store_.step_number || laid_down_) {
    piece.spent += departure(piece, store_.step_number);
    piece.excursion = piece.before = std::numeric_limits<double>::infinity();
    ++report.sleep.woken;
  }
  piece.since = -1;
}

/// Wakes what has its pins or springs changed by the end of the step, and what the bound no longer
/// lets sleep.
template <class T>
void SleepingStep<T>::wake_pulled(double time, StepReport& report) {
  const Scene& scene = store_.scene();
  const Model& model = store_.model();
  std::vector<unsigned char> near(component_count_, 0);
  const auto pulled = [&](Index v) { near[at(component_of_[at(v)])] = 1; };
  for (const auto& p : model.pinned) {
    const Pin& pin = scene.pins[at(p.pin)];
    if (pin_holds(pin, time) != pin_holds(pin, store_.time)) pulled(p.vertex);
    if (!pin_holds(pin, time)) continue;
    const Vec3<T> target = vec_cast<T>(pinned_position(scene, p, time, placed_));
    if (length_sq(target - positions()[at(p.vertex)]) > T(0)) pulled(p.vertex);
  }
  if (!scene.handles.empty())
    for (const Index v :
         changed(springs_at(scene, model, store_.time), springs_at(scene, model, time)))
      pulled(v);
  const double bound = scene.implicit.sleep_distance;
  for (std::size_t p = 0; p < component_count_; ++p) {
    if (!sleeps(p)) continue;
    const SleepComponent& piece = store_.sleep.pieces[p];
    if (near[p] != 0 || piece.spent + departure(piece, last_step()) > bound) wake(p, report);
  }
}

/// Where all vertices would be at the end of a step if nothing but gravity acted, as
/// ImplicitStep::predict() has it.
template <class T>
std::vector<Vec3<T>> SleepingStep<T>::predicted(double dt) const {
  const Scene& scene = store_.scene();
  const Model& model = store_.model();
  const Span<const Vec3<T>> x = positions();
  const Span<const Vec3<T>> velocity = store_.rank(0).velocities.span();
  const double fall = length(scene.gravity) * dt * dt;
  const double share = std::min(1.0, contact_thickness(scene.contact) / std::max(fall, 1e-300));
  const Vec3<T> by_gravity = vec_cast<T>(share * dt * dt * scene.gravity);
  std::vector<Vec3<T>> ends(x.begin(), x.end());
  for (std::size_t v = 0; v < component_of_.size(); ++v)
    ends[v] += static_cast<T>(dt) * velocity[v] + by_gravity;
  for (const auto& p : model.pinned)
    if (pin_holds(scene.pins[at(p.pin)], store_.time + dt))
      ends[at(p.vertex)] = vec_cast<T>(pinned_position(scene, p, store_.time + dt, placed_));
  for (std::size_t i = 0; i < placed_.size(); ++i)
    ends[component_of_.size() + i] = vec_cast<T>(placed_[i]);
  return ends;
}

/// Wakes what something comes near to as it is predicted, and what that comes near to in turn.
template <class T>
void SleepingStep<T>::wake_approached(double dt, StepReport& report) {
  if (!any_sleeps()) return;
  const std::vector<Vec3<T>> ends = predicted(dt);
  bool woken = true;
  while (woken) {
    std::vector<unsigned char> near(component_count_, 0);
    look_at_all<T>(
        store_.model(), [this](const Tri& t) { return !sleeps(t); }, positions(), ends, boxes_,
        near);
    woken = false;
    for (std::size_t p = 0; p < component_count_; ++p)
      if (near[p] != 0 && sleeps(p)) {
        wake(p, report);
        woken = true;
      }
  }
}

template <class T>
void SleepingStep<T>::make_boxes() {
  const Model& model = store_.model();
  std::vector<Tri> triangles;
  std::vector<Index> piece;
  for (Index t = 0; t < model.cloth_triangle_count; ++t) {
    const Tri& tri = model.triangles[at(t)];
    if (!sleeps(tri)) continue;
    triangles.push_back(tri);
    piece.push_back(component_of_[at(tri.v[0])]);
  }
  const Span<const Vec3<T>> x = positions();
  std::vector<Vec3<double>> points;
  points.reserve(x.size());
  for (const Vec3<T>& p : x) points.push_back(vec_cast<double>(p));
  boxes_ = RestBoxes(points, triangles, std::move(piece),
                     reach_thicknesses * contact_thickness(store_.scene().contact));
}

/// Cloth that falls asleep with this step does not move from now on, and counts as having been at
/// rest before.
template <class T>
void SleepingStep<T>::lay_down(StepReport& report) {
  std::vector<unsigned char> fresh(component_count_, 0);
  for (std::size_t p = 0; p < component_count_; ++p)
    if (store_.sleep.pieces[p].since == store_.step_number) {
      fresh[p] = 1;
      ++report.sleep.fell_asleep;
    }
  if (std::find(fresh.begin(), fresh.end(), 1) == fresh.end()) return;
  for (int r = 0; r < store_.devices().size(); ++r)
    submit_host(store_.devices()[r].compute(), [this, r, &fresh] {
      RankState<T>& state = store_.rank(r);
      for (std::size_t v = 0; v < component_of_.size(); ++v) {
        if (fresh[at(component_of_[v])] == 0) continue;
        state.velocities.data()[v] = state.previous_velocities.data()[v] = Vec3<T>{0, 0, 0};
        state.previous_positions.data()[v] = state.positions.data()[v];
        state.touched.data()[v] = 0;
      }
    });
  sync_ranks(store_.devices());
  laid_down_ = true;
}

/// @return whether the step stands: nothing came near a sleeper
template <class T>
bool SleepingStep<T>::advance_awake(double dt, StepReport& report) {
  const auto& pieces = store_.sleep.pieces;
  if (std::all_of(pieces.begin(), pieces.end(),
                  [](const SleepComponent& p) { return p.since >= 0; })) {
    advance_obstacles(dt);
    report.work = 0;
    return true;
  }
  make_awake();
  awake_->step.publish_on(whole_.board());
  Store<T>& store = awake_->store;
  store.time = store_.time;
  store.previous_step = store_.previous_step;
  store.step_number = store_.step_number;
  store.backoff = store_.backoff;
  std::vector<unsigned char> near(component_count_, 0);
  awake_->step.watch([&](Span<const Vec3<T>> x0, Span<const Vec3<T>> x1) {
    look_at_all<T>(
        store.model(), [](const Tri&) { return true; }, x0, x1, boxes_, near);
  });
  try {
    awake_->step.advance(dt, report);
  } catch (...) {
    awake_.reset();  // it may have gone part of the way
    throw;
  }
  awake_->step.watch({});
  bool stands = true;
  for (std::size_t p = 0; p < component_count_; ++p)
    if (near[p] != 0 && sleeps(p)) {
      wake(p, report);
      stands = false;
    }
  if (stands)
    write_back();
  else
    awake_.reset();
  return stands;
}

template <class T>
void SleepingStep<T>::note_excursions() {
  SleepState<T>& state = store_.sleep;
  const Span<const Vec3<T>> x = positions();
  for (std::size_t v = 0; v < component_of_.size(); ++v) {
    SleepComponent& piece = state.pieces[at(component_of_[v])];
    if (piece.since >= 0) continue;
    const Vec3<double> from = vec_cast<double>(x[v]) - vec_cast<double>(state.marks[0][v]);
    piece.excursion = std::max(piece.excursion, length(from));
  }
}

template <class T>
void SleepingStep<T>::report_sleep(StepReport& report) const {
  report.sleep.pieces = static_cast<std::int64_t>(component_count_);
  for (const Index p : component_of_) report.sleep.asleep += sleeps(at(p)) ? 1 : 0;
  for (const SleepComponent& piece : store_.sleep.pieces) {
    const double now = piece.since >= 0 ? departure(piece, store_.step_number + 1) : 0;
    report.sleep.departure = std::max(report.sleep.departure, piece.spent + now);
  }
}

template class SleepingStep<float>;
template class SleepingStep<double>;

}  // namespace weft
