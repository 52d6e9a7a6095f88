#include "host/asynchronous/window.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/asynchronous/order.hpp"
#include "host/asynchronous/seconds.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

std::vector<Index> order_of(const Model& model) {
  std::vector<Index> order = reverse_cuthill_mckee(model.cloth_vertex_count, model.edges);
  for (Index v = model.cloth_vertex_count; v < model.vertex_count; ++v) order.push_back(v);
  return order;
}

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[at(order[i])] = static_cast<Index>(i);
  return place;
}

}  // namespace

AsynchronousCounts& AsynchronousCounts::operator+=(const AsynchronousCounts& b) {
  windows += b.windows;
  rollbacks += b.rollbacks;
  clean_windows += b.clean_windows;
  ticks += b.ticks;
  elements += b.elements;
  layer_pairs += b.layer_pairs;
  acting_pairs += b.acting_pairs;
  resimulated += b.resimulated;
  layers_added += b.layers_added;
  candidates += b.candidates;
  slabs += b.slabs;
  failsafe += b.failsafe;
  ccd_tests += b.ccd_tests;
  pairs_max = std::max(pairs_max, b.pairs_max);
  layers_max = std::max(layers_max, b.layers_max);
  ahead_started += b.ahead_started;
  ahead_accepted += b.ahead_accepted;
  ahead_cancelled += b.ahead_cancelled;
  ahead_held += b.ahead_held;
  beside_detection += b.beside_detection;
  window_length = b.window_length;
  useful += b.useful;
  resimulation += b.resimulation;
  detection += b.detection;
  unneeded += b.unneeded;
  bookkeeping += b.bookkeeping;
  return *this;
}

Windows::Windows(const Scene& scene, const Model& model, int threads, const std::atomic<bool>* stop)
    : scene_(scene),
      model_(model),
      stop_(stop),
      settings_(scene.asynchronous),
      workers_(threads),
      order_(order_of(model)),
      place_(inverse(order_)),
      buckets_(scene, model, place_, order_),
      detection_(scene, model, place_, settings_.narrow == NarrowPhase::slabs) {
  if (settings_.optimistic && threads > 1) ahead_.emplace(threads);
}

void Windows::start(const std::vector<Vec3<double>>& positions,
                    const std::vector<Vec3<double>>& velocities, double time,
                    const std::vector<double>& driven, bool finished) {
  const std::size_t count = order_.size();
  VertexMotion& motion = now_.motion;
  motion.x.resize(count);
  motion.v.assign(count, {});
  motion.t.assign(count, time);
  motion.inv_mass.assign(count, 0);
  buckets_.bodies().begin(driven, motion);
  const auto fixed = fixed_vertices(scene_, model_, time);
  for (std::size_t i = 0; i < count; ++i) {
    const auto from = at(order_[i]);
    motion.x[i] = positions[from];
    if (fixed[from] != 0) continue;
    motion.v[i] = velocities[from];
    motion.inv_mass[i] = 1 / model_.mass[from];
  }
  time_ = time;
  buckets_.begin(time, now_);
  detection_.sort(motion.x);
  if (!finished)
    now_.layers.set(detection_.within(motion, time, rule(), settings_.layers, workers_));
}

Windows::Memory Windows::memory() const {
  Memory memory{saved_.bytes() + now_.bytes(), 0};
  if (ahead_) memory.ahead = ahead_->course.bytes();
  return memory;
}

void Windows::finish(std::vector<Vec3<double>>& positions, std::vector<Vec3<double>>& velocities) {
  for (std::size_t i = 0; i < order_.size(); ++i) {
    positions[at(order_[i])] = now_.motion.position(i, time_);
    if (order_[i] < model_.cloth_vertex_count) velocities[at(order_[i])] = now_.motion.v[i];
  }
}

bool Windows::finite() const {
  double sum = 0;
  for (std::size_t i = 0; i < now_.motion.x.size(); ++i)
    for (int c = 0; c < 3; ++c) sum += 0 * now_.motion.x[i][c] + 0 * now_.motion.v[i][c];
  return sum == 0;
}

bool Windows::fail(StepReport& report, Failure failure, const std::string& detail,
                   const std::optional<Vec3<double>>& place) const {
  report.failure = failure;
  report.failure_detail = detail;
  report.failure_place = place;
  return false;
}

/// The closest point of the pair's first primitive. [m]
Vec3<double> Windows::place_of(const PrimitivePair& pair) const {
  Vec3<double> x[4];
  for (int j = 0; j < 4; ++j) x[j] = now_.motion.position(at(pair.v[j]), time_);
  const Proximity<double> closest = pair.closest(x);
  Vec3<double> place{0, 0, 0};
  for (int j = 0; j < pair.first_count(); ++j) place += closest.w[j] * x[j];
  return place;
}

/// Gives each pair its next layer, if the scene allows that.
bool Windows::deepen(const std::vector<PrimitivePair>& missed, StepReport& report) {
  int deepest = 0;
  const PrimitivePair* deepest_pair = &missed.front();
  for (const PrimitivePair& pair : missed) {
    const int depth = now_.layers.depth(pair.key) + 1;
    if (depth <= deepest) continue;
    deepest = depth;
    deepest_pair = &pair;
  }
  const std::string layer = "penalty layer " + std::to_string(deepest);
  if (deepest > settings_.layers)
    return fail(
        report, Failure::layers,
        layer + " would be needed; the last one is layer " + std::to_string(settings_.layers),
        place_of(*deepest_pair));
  if (rule().step_of(deepest) < settings_.smallest_step)
    return fail(report, Failure::small_step,
                layer + " would need a step below " + seconds_text(settings_.smallest_step),
                place_of(*deepest_pair));
  now_.layers.deepen(missed);
  report.asynchronous.layers_added += static_cast<std::int64_t>(missed.size());
  report.impacts += static_cast<std::int64_t>(missed.size());
  return true;
}

/// Gives layers to pairs that are likely to need one, as far as the scene's caps go.
void Windows::deepen_expected(std::vector<PrimitivePair> pairs) {
  std::erase_if(pairs, [&](const PrimitivePair& pair) {
    const int depth = now_.layers.depth(pair.key) + 1;
    return depth > settings_.layers || rule().step_of(depth) < settings_.smallest_step;
  });
  now_.layers.deepen(pairs);
}

/// Detection of the window that now_ has gone through.
void Windows::detect(const WorkerGroup& group, std::atomic<bool>& found, Look& look) {
  const double begin = seconds();
  look.missed = detection_.missed(now_.trajectories, now_.motion, now_.layers, rule(), group, found,
                                  look.counts);
  if (look.missed.empty()) look.expected = detection_.expected(rule(), group.workers());
  // Going on without the layers that are expected to be needed costs more windows than it saves.
  if (!look.expected.empty()) found.store(true, std::memory_order_relaxed);
  look.time = seconds() - begin;
}

/// Detects while other threads begin with the next window as if nothing will be found: from where
/// this one ends, without the layers that have become idle.
void Windows::detect_and_go_on(double to, double after, Look& look) {
  Ahead& ahead = *ahead_;
  const double begin = seconds();
  std::atomic<bool> found{false}, looked{false}, gone{false};
  ahead.both.run(2, [&](int n) {
    if (n == 0) {
      detect({ahead.looking, workers_, &gone}, found, look);
      looked.store(true, std::memory_order_release);
      return;
    }
    ahead.course.motion = now_.motion;
    ahead.course.phase = now_.phase;
    ahead.course.layers.set(now_.layers.kept(rule(), now_.motion, to, ahead.going));
    ahead.pass =
        buckets_.simulate(to, after, ahead.course, {ahead.going, workers_, &looked, &found});
    gone.store(true, std::memory_order_release);
  });
  look.over = seconds() - begin - look.time;
  look.went_on = !found.load(std::memory_order_relaxed);
}

/// Detection, beside the next window where there is one and that has been worth it of late.
void Windows::look_at(double to, double after, Look& look, AsynchronousCounts& counts) {
  const bool could = ahead_ && after > to;
  if (could && record_.worthwhile()) {
    detect_and_go_on(to, after, look);
    book_ahead(look, counts);
  } else {
    if (could) ++counts.ahead_held;
    std::atomic<bool> found{false};
    detect({workers_, workers_}, found, look);
  }
  record_.learn(look.clear());
}

/// Algorithm 1.
/// @param after end of the next window, or `to` if that is not to begin yet
bool Windows::window(double from, double to, double after, StepReport& report) {
  AsynchronousCounts& counts = report.asynchronous;
  const double begin = seconds();
  double accounted = 0;
  bool begun = begun_;
  begun_ = false;
  if (!begun) {
    saved_ = now_.motion;
    saved_phase_ = now_.phase;
  }
  ++counts.windows;
  counts.window_length = to - from;
  Look look;
  for (int rollback = 0;; ++rollback) {
    Pass pass;
    if (begun) {
      pass = ahead_->pass;
      begun = false;
    } else {
      pass = buckets_.simulate(from, to, now_, {workers_, workers_, nullptr, stop_});
      accounted += pass.time;
    }
    if (stop_ != nullptr && stop_->load(std::memory_order_relaxed))
      return fail(report, Failure::stopped, "");
    if (!finite()) return fail(report, Failure::not_finite, "a window ended in NaN or infinity");
    look = {};
    look_at(to, after, look, counts);
    accounted += look.time + look.over;
    book(look, counts);
    if (look.missed.empty()) {
      accept(pass, counts);
      if (rollback == 0) ++counts.clean_windows;
      break;
    }
    counts.resimulation += pass.time;
    counts.resimulated += pass.elements + pass.pairs;
    ++counts.rollbacks;
    now_.motion = saved_;
    now_.phase = saved_phase_;
    if (rollback == settings_.rollbacks)
      return fail(report, Failure::rollbacks,
                  std::to_string(look.missed.size()) +
                      (look.missed.size() == 1 ? " pair still comes" : " pairs still come") +
                      " too close after " + std::to_string(rollback) +
                      (rollback == 1 ? " rollback" : " rollbacks"),
                  place_of(look.missed.front()));
    if (!deepen(look.missed, report)) return false;
  }
  if (observer_ != nullptr)
    observer_(context_, now_.trajectories, now_.layers, now_.motion, rule());
  time_ = to;
  if (look.went_on) {
    std::swap(now_, ahead_->course);
    std::swap(saved_, ahead_->course.motion);
    saved_phase_ = ahead_->course.phase;
    begun_ = true;
  } else {
    now_.layers.set(now_.layers.kept(rule(), now_.motion, to, workers_));
    if (!look.expected.empty()) deepen_expected(look.expected);
  }
  counts.bookkeeping += seconds() - begin - accounted;
  return true;
}

/// Books what a detection did.
void Windows::book(const Look& look, AsynchronousCounts& counts) const {
  counts.detection += look.time;
  counts.candidates += look.counts.candidates;
  counts.slabs += look.counts.narrow.slabs;
  counts.failsafe += look.counts.narrow.failsafe;
  counts.ccd_tests += look.counts.narrow.ccd;
  counts.layers_max = std::max(counts.layers_max, now_.layers.deepest());
  counts.pairs_max =
      std::max(counts.pairs_max, static_cast<std::int64_t>(now_.layers.pairs().size()));
}

/// Books the next window's begin: of its time only what it took longer than detection, so that all
/// times add up to that of the clock.
void Windows::book_ahead(const Look& look, AsynchronousCounts& counts) {
  Pass& pass = ahead_->pass;
  ++counts.ahead_started;
  counts.beside_detection += std::max(pass.time - look.over, 0.0);
  if (!look.went_on) {
    ++counts.ahead_cancelled;
    counts.resimulation += look.over;
    return;
  }
  ++counts.ahead_accepted;
  pass.layer_time *= pass.time > 0 ? look.over / pass.time : 0;
  pass.time = look.over;
}

/// Books a pass that stands.
void Windows::accept(const Pass& pass, AsynchronousCounts& counts) {
  const double idle = pass.pairs > 0
                          ? pass.layer_time * static_cast<double>(pass.pairs - pass.acting) /
                                static_cast<double>(pass.pairs)
                          : 0;
  counts.useful += pass.time - idle;
  counts.unneeded += idle;
  counts.ticks += pass.ticks;
  counts.elements += pass.elements;
  counts.layer_pairs += pass.pairs;
  counts.acting_pairs += pass.acting;
}

bool Windows::advance(double end, StepReport& report) {
  const double start = time_;
  const auto count = std::max(1.0, std::ceil((end - start) / settings_.window - 1e-9));
  const auto end_of = [&](double k) {
    return k < count ? start + (end - start) * (k / count) : end;
  };
  begun_ = false;
  for (double k = 1; k <= count; ++k)
    if (!window(time_, end_of(k), end_of(k + 1), report)) return false;
  report.proximities =
      std::max(report.proximities, static_cast<std::int64_t>(now_.layers.pairs().size()));
  return true;
}

}  // namespace weft
