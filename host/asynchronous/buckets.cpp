#include "host/asynchronous/buckets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host/asynchronous/seconds.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Fewer vertices than this are advanced sooner by one thread.
constexpr std::size_t least_vertices_per_thread = 2048;
/// [s] Interval at which gravity and prescribed motion are updated: straight segments of that
/// length deviate by a micrometre from a path with an acceleration of 10 m/s^2.
constexpr double slow_step = 1e-3;
/// Share of the longest stable step of one pair that layers take: up to 16 pairs may pull at a
/// vertex at once, as their stiffnesses add up.
constexpr double layer_share = 0.25;

/// Two vertices of the smallest mass, pushed apart by the first layer: omega^2 = 2 r(1) / m.
LayerRule layer_rule(const Scene& scene, const Model& model) {
  const double least = *std::min_element(model.mass.begin(), model.mass.end());
  const double omega = std::sqrt(2 * scene.asynchronous.stiffness / least);
  return {contact_thickness(scene.contact), scene.asynchronous.stiffness, layer_share * 2 / omega};
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

ForceBuckets::ForceBuckets(const Scene& scene, const Model& model, const std::vector<Index>& place,
                           const std::vector<Index>& order)
    : scene_(scene),
      cloth_count_(at(model.cloth_vertex_count)),
      sheet_(model, place, order),
      prescribed_(scene, model, place),
      bodies_(scene, model, place),
      forces_{layer_rule(scene, model), scene.asynchronous.restitution, frictions(scene, model),
              model.cloth_vertex_count},
      plates_(plates_of(scene, model, prescribed_.release_times(), place, order)) {
  internal_step_ = std::numeric_limits<double>::infinity();
  for (const PlateMatrix& plate : plates_)
    internal_step_ = std::min(internal_step_, sheet_.stable_step(plate));
  internal_step_ = std::min(internal_step_, slow_step);
  const double least = scene.asynchronous.smallest_step;
  if (const double stable = std::min(internal_step_, forces_.rule.step); !(stable >= least))
    throw SceneError(scene.file, "method.type",
                     "\"asynchronous\" in steps of " + seconds_text(stable),
                     "at least " + seconds_text(least) + ": the steps in which " +
                         (internal_step_ < forces_.rule.step ? "stretching and bending are"
                                                             : "the first penalty layer is") +
                         " stable, which longer edges, softer or heavier cloth make longer");
}

Ticks ForceBuckets::ticks_of(int bucket) const {
  if (bucket == prescribed || bucket == gravity) return {slow_step};
  if (bucket == internal || bucket == driven_bodies) return {internal_step_};
  return {forces_.rule.step_of(bucket - first_layer + 1)};
}

void ForceBuckets::begin(double time, WindowState& course) {
  course.phase = prescribed_.phase(time);
  const auto next_of = [&](int bucket) {
    const Ticks ticks = ticks_of(bucket);
    return ticks.time(ticks.first_from(time));
  };
  if (const double next = next_of(prescribed); prescribed_.changes() && next > time)
    prescribed_.aim(time, next, course.motion, nullptr);
  if (const double next = next_of(driven_bodies); bodies_.any() && next > time)
    bodies_.carry(time, next, course.motion, nullptr);
}

void ForceBuckets::advance_cloth(double time, WindowState& course, Workers& workers) const {
  VertexMotion& motion = course.motion;
  Vec3<double>* const breakpoints = course.trajectories.add_all(time);
  workers.share(cloth_count_, least_vertices_per_thread, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; ++i) {
      motion.advance(i, time);
      breakpoints[i] = motion.x[i];
    }
  });
}

/// Algorithm 2. The first tick of all, at t = 0, acts for half a step: that makes sums over ticks
/// trapezoidal, so that constant forces move vertices exactly.
void ForceBuckets::process(const Tick& tick, WindowState& course, Workers& workers, Pass& pass) {
  VertexMotion& motion = course.motion;
  const Ticks ticks = ticks_of(tick.bucket);
  const double h = tick.number == 0 ? ticks.step / 2 : ticks.step;
  ++pass.ticks;
  if (tick.bucket >= first_layer) {
    const double begin = seconds();
    const LayerTick done = course.layers.act(tick.bucket - first_layer + 1, h, tick.time, forces_,
                                             motion, course.trajectories, workers);
    pass.pairs += done.pairs;
    pass.acting += done.acting;
    pass.layer_time += seconds() - begin;
    return;
  }
  if (tick.bucket == prescribed) {
    prescribed_.aim(tick.time, ticks.time(tick.number + 1), motion, &course.trajectories);
    course.phase = prescribed_.phase(tick.time);
    return;
  }
  if (tick.bucket == driven_bodies) {
    const double next = ticks.time(tick.number + 1);
    bodies_.turn(tick.time, next, h, motion);
    bodies_.carry(tick.time, next, motion, &course.trajectories);
    return;
  }
  advance_cloth(tick.time, course, workers);
  if (tick.bucket == internal) {
    sheet_.kick(h, plates_[course.phase], motion, workers);
    pass.elements += static_cast<std::int64_t>(sheet_.element_count());
    return;
  }
  for (std::size_t i = 0; i < cloth_count_; ++i)
    if (motion.inv_mass[i] > 0) motion.v[i] += scene_.gravity * h;
}

Pass ForceBuckets::simulate(double from, double to, WindowState& course, const WorkerGroup& group) {
  Pass pass;
  const double begin = seconds();
  course.trajectories.reset(course.motion, cloth_count_, from);
  TickQueue queue;
  for (int bucket = 0; bucket < first_layer + course.layers.deepest(); ++bucket) {
    if (bucket == prescribed && !prescribed_.changes()) continue;
    if (bucket == driven_bodies && !bodies_.any()) continue;
    const Ticks ticks = ticks_of(bucket);
    const std::int64_t first = ticks.first_from(from);
    queue.push({ticks.time(first), bucket, first});
  }
  while (queue.top().time < to) {
    if (group.stopped()) {
      pass.stopped = true;
      break;
    }
    const Tick tick = queue.top();
    queue.pop();
    process(tick, course, group.workers(), pass);
    queue.push({ticks_of(tick.bucket).time(tick.number + 1), tick.bucket, tick.number + 1});
  }
  course.trajectories.finish(course.motion, to);
  pass.time = seconds() - begin;
  return pass;
}

}  // namespace weft
