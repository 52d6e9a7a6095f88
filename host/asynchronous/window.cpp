#include "host/asynchronous/window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>

#include "host/asynchronous/order.hpp"
#include "host/implicit/geometry.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

constexpr std::size_t least_share = 256;
/// [s] Ticks of gravity and of what is prescribed: straight pieces of that length miss a path that
/// bends with 10 m/s^2 by a micrometre.
constexpr double slow_step = 1e-3;
/// Share of the longest stable step of one pair that layers take: up to 16 pairs may pull at a
/// vertex at once, as their stiffnesses add up.
constexpr double layer_share = 0.25;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

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

/// Two vertices of the smallest mass, pushed apart by the first layer: omega^2 = 2 r(1) / m.
LayerRule layer_rule(const Scene& scene, const Model& model) {
  const double least = *std::min_element(model.mass.begin(), model.mass.end());
  const double omega = std::sqrt(2 * scene.asynchronous.stiffness / least);
  return {scene.contact.thickness, scene.asynchronous.stiffness, layer_share * 2 / omega};
}

/// [vertices] empty if nothing rubs.
std::vector<double> frictions(const Scene& scene, const Model& model) {
  std::vector<double> mu(at(model.cloth_vertex_count), scene.contact.friction);
  for (const Index o : model.obstacle_of_vertex) mu.push_back(scene.obstacles[at(o)].friction);
  if (std::all_of(mu.begin(), mu.end(), [](double m) { return m == 0; })) mu.clear();
  return mu;
}

std::vector<PlateMatrix> plates_of(const Scene& scene, const Model& model,
                                   const std::vector<double>& releases,
                                   const std::vector<Index>& place,
                                   const std::vector<Index>& order) {
  std::vector<PlateMatrix> plates;
  for (std::size_t p = 0; p <= releases.size(); ++p) {
    const double time = p == 0 ? 0 : releases[p - 1];
    const auto held = held_triangles(model, fixed_vertices(scene, model, time));
    plates.push_back(renumbered(make_plate(scene, model, held), place, order));
  }
  return plates;
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
  window_length = b.window_length;
  useful += b.useful;
  resimulation += b.resimulation;
  detection += b.detection;
  unneeded += b.unneeded;
  bookkeeping += b.bookkeeping;
  return *this;
}

Windows::Windows(const Scene& scene, const Model& model, int threads)
    : scene_(scene),
      model_(model),
      settings_(scene.asynchronous),
      workers_(threads),
      order_(order_of(model)),
      place_(inverse(order_)),
      sheet_(model, place_, order_),
      prescribed_(scene, model, place_),
      bodies_(scene, model, place_),
      detection_(scene, model, place_, settings_.narrow == NarrowPhase::slabs),
      forces_{layer_rule(scene, model), settings_.restitution, frictions(scene, model),
              model.cloth_vertex_count},
      plates_(plates_of(scene, model, prescribed_.release_times(), place_, order_)),
      tuner_(settings_.window) {
  internal_step_ = std::numeric_limits<double>::infinity();
  for (const PlateMatrix& plate : plates_)
    internal_step_ = std::min(internal_step_, sheet_.stable_step(plate));
  internal_step_ = std::min(internal_step_, slow_step);
  const double least = settings_.smallest_step;
  if (!(std::min(internal_step_, forces_.rule.step) >= least))
    throw SceneError(scene.file, "method.asynchronous.smallest_step", std::to_string(least),
                     "at most the stable steps of stretching and bending, " +
                         std::to_string(internal_step_) + " s, and of the first penalty layer, " +
                         std::to_string(forces_.rule.step) + " s");
}

void Windows::start(const std::vector<Vec3<double>>& positions,
                    const std::vector<Vec3<double>>& velocities, double time,
                    const std::vector<double>& driven) {
  const std::size_t count = order_.size();
  const bool known = count == finished_x_.size() && time == time_ && positions == finished_x_ &&
                     velocities == finished_v_;
  motion_.x.resize(count);
  motion_.v.assign(count, {});
  motion_.t.assign(count, time);
  motion_.inv_mass.assign(count, 0);
  bodies_.begin(driven, motion_);
  const auto fixed = fixed_vertices(scene_, model_, time);
  for (std::size_t i = 0; i < count; ++i) {
    const auto from = at(order_[i]);
    motion_.x[i] = positions[from];
    if (fixed[from] != 0) continue;
    motion_.v[i] = velocities[from];
    motion_.inv_mass[i] = 1 / model_.mass[from];
  }
  time_ = time;
  phase_ = prescribed_.phase(time);
  const auto next_of = [&](int bucket) {
    const Ticks ticks = ticks_of(bucket);
    return ticks.time(ticks.first_from(time));
  };
  if (const double next = next_of(prescribed); prescribed_.changes() && next > time)
    prescribed_.aim(time, next, motion_, nullptr);
  if (const double next = next_of(driven_bodies); bodies_.any() && next > time)
    bodies_.carry(time, next, motion_, nullptr);
  detection_.sort(motion_.x);
  if (!known)
    layers_.set(detection_.within(motion_, time, forces_.rule, settings_.layers, workers_));
}

void Windows::finish(std::vector<Vec3<double>>& positions, std::vector<Vec3<double>>& velocities) {
  for (std::size_t i = 0; i < order_.size(); ++i) {
    positions[at(order_[i])] = motion_.position(i, time_);
    if (order_[i] < model_.cloth_vertex_count) velocities[at(order_[i])] = motion_.v[i];
  }
  finished_x_ = positions;
  finished_v_ = velocities;
}

Ticks Windows::ticks_of(int bucket) const {
  if (bucket == prescribed || bucket == gravity) return {slow_step};
  if (bucket == internal || bucket == driven_bodies) return {internal_step_};
  return {forces_.rule.step_of(bucket - first_layer + 1)};
}

void Windows::advance_cloth(double time) {
  Vec3<double>* const knots = ways_.add_all(time);
  workers_.share(at(model_.cloth_vertex_count), least_share, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; ++i) {
      motion_.advance(i, time);
      knots[i] = motion_.x[i];
    }
  });
}

/// Algorithm 2. The first tick of all, at t = 0, acts for half a step: that makes sums over ticks
/// trapezoidal, so that constant forces move vertices exactly.
void Windows::process(const Tick& tick, Pass& pass) {
  const Ticks ticks = ticks_of(tick.bucket);
  const double h = tick.number == 0 ? ticks.step / 2 : ticks.step;
  ++pass.ticks;
  if (tick.bucket >= first_layer) {
    const double begin = seconds();
    const LayerTick done =
        layers_.act(tick.bucket - first_layer + 1, h, tick.time, forces_, motion_, ways_, workers_);
    pass.pairs += done.pairs;
    pass.acting += done.acting;
    pass.layer_time += seconds() - begin;
    return;
  }
  if (tick.bucket == prescribed) {
    prescribed_.aim(tick.time, ticks.time(tick.number + 1), motion_, &ways_);
    phase_ = prescribed_.phase(tick.time);
    return;
  }
  if (tick.bucket == driven_bodies) {
    const double next = ticks.time(tick.number + 1);
    bodies_.turn(tick.time, next, h, motion_);
    bodies_.carry(tick.time, next, motion_, &ways_);
    return;
  }
  advance_cloth(tick.time);
  if (tick.bucket == internal) {
    sheet_.kick(h, plates_[phase_], motion_, workers_);
    pass.elements += static_cast<std::int64_t>(sheet_.element_count());
    return;
  }
  for (std::size_t i = 0; i < at(model_.cloth_vertex_count); ++i)
    if (motion_.inv_mass[i] > 0) motion_.v[i] += scene_.gravity * h;
}

Windows::Pass Windows::simulate(double from, double to) {
  Pass pass;
  const double begin = seconds();
  ways_.reset(motion_, at(model_.cloth_vertex_count), from);
  TickQueue queue;
  for (int bucket = 0; bucket < first_layer + layers_.deepest(); ++bucket) {
    if (bucket == prescribed && !prescribed_.changes()) continue;
    if (bucket == driven_bodies && !bodies_.any()) continue;
    const Ticks ticks = ticks_of(bucket);
    const std::int64_t first = ticks.first_from(from);
    queue.push({ticks.time(first), bucket, first});
  }
  while (queue.top().time < to) {
    const Tick tick = queue.top();
    queue.pop();
    process(tick, pass);
    queue.push({ticks_of(tick.bucket).time(tick.number + 1), tick.bucket, tick.number + 1});
  }
  ways_.finish(motion_, to);
  pass.time = seconds() - begin;
  return pass;
}

bool Windows::finite() const {
  double sum = 0;
  for (std::size_t i = 0; i < motion_.x.size(); ++i)
    for (int c = 0; c < 3; ++c) sum += 0 * motion_.x[i][c] + 0 * motion_.v[i][c];
  return sum == 0;
}

bool Windows::fail(StepReport& report, Failure failure, const std::string& detail) const {
  report.failure = failure;
  report.failure_detail = detail;
  return false;
}

/// Gives each pair its next layer, if the scene allows that.
bool Windows::deepen(const std::vector<PrimitivePair>& missed, StepReport& report) {
  int deepest = 0;
  for (const PrimitivePair& pair : missed) deepest = std::max(deepest, layers_.depth(pair.key) + 1);
  const std::string layer = "penalty layer " + std::to_string(deepest);
  if (deepest > settings_.layers)
    return fail(report, Failure::layers,
                layer + " would be needed, method.asynchronous.layers allows " +
                    std::to_string(settings_.layers));
  if (forces_.rule.step_of(deepest) < settings_.smallest_step)
    return fail(report, Failure::small_step,
                layer + " would need a step below method.asynchronous.smallest_step");
  layers_.deepen(missed);
  report.asynchronous.layers_added += static_cast<std::int64_t>(missed.size());
  report.impacts += static_cast<std::int64_t>(missed.size());
  return true;
}

/// Gives layers to pairs that are likely to need one, as far as the scene's caps go.
void Windows::deepen_expected(std::vector<PrimitivePair> pairs) {
  std::erase_if(pairs, [&](const PrimitivePair& pair) {
    const int depth = layers_.depth(pair.key) + 1;
    return depth > settings_.layers || forces_.rule.step_of(depth) < settings_.smallest_step;
  });
  layers_.deepen(pairs);
}

/// Algorithm 1.
bool Windows::window(double from, double to, StepReport& report) {
  AsynchronousCounts& counts = report.asynchronous;
  const double begin = seconds();
  double accounted = 0;
  saved_ = motion_;
  const std::size_t saved_phase = phase_;
  ++counts.windows;
  counts.window_length = to - from;
  for (int rollback = 0;; ++rollback) {
    const Pass pass = simulate(from, to);
    accounted += pass.time;
    if (!finite()) return fail(report, Failure::not_finite, "a window ended in NaN or infinity");
    DetectionCounts found;
    const double before = seconds();
    const auto missed = detection_.missed(ways_, motion_, layers_, forces_.rule, workers_, found);
    counts.detection += seconds() - before;
    accounted += seconds() - before;
    counts.candidates += found.candidates;
    counts.slabs += found.narrow.slabs;
    counts.failsafe += found.narrow.failsafe;
    counts.ccd_tests += found.narrow.ccd;
    counts.layers_max = std::max(counts.layers_max, layers_.deepest());
    counts.pairs_max =
        std::max(counts.pairs_max, static_cast<std::int64_t>(layers_.pairs().size()));
    if (missed.empty()) {
      accept(pass, counts);
      if (rollback == 0) ++counts.clean_windows;
      break;
    }
    counts.resimulation += pass.time;
    counts.resimulated += pass.elements + pass.pairs;
    ++counts.rollbacks;
    if (rollback == settings_.rollbacks)
      return fail(report, Failure::rollbacks,
                  std::to_string(missed.size()) + " pairs still come too close after " +
                      std::to_string(rollback) + " rollbacks");
    motion_ = saved_;
    phase_ = saved_phase;
    if (!deepen(missed, report)) return false;
  }
  if (observer_ != nullptr) observer_(context_, ways_, layers_, motion_, forces_.rule);
  const auto expected = detection_.expected(layers_, forces_.rule);
  layers_.drop_idle(forces_.rule, motion_, to);
  if (!expected.empty()) deepen_expected(expected);
  time_ = to;
  counts.bookkeeping += seconds() - begin - accounted;
  return true;
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
  const double length = settings_.tune_window ? tuner_.window() : settings_.window;
  const auto count = std::max(1.0, std::ceil((end - start) / length - 1e-9));
  for (double k = 1; k <= count; ++k)
    if (!window(time_, k < count ? start + (end - start) * (k / count) : end, report)) return false;
  report.proximities =
      std::max(report.proximities, static_cast<std::int64_t>(layers_.pairs().size()));
  if (settings_.tune_window) tuner_.learn(report.asynchronous, end - start);
  return true;
}

}  // namespace weft
