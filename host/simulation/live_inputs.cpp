#include "host/simulation/live_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "host/base/bytes.hpp"
#include "host/input/checker.hpp"
#include "host/input/quantity.hpp"
#include "host/scene/part_check.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// @param what   the vectors' name in messages
/// @param of     what their coordinates are
void check_vectors(const Scene& scene, const std::string& part, std::size_t count,
                   Span<const Vec3<double>> vectors, const char* what, const Quantity& of) {
  if (vectors.size() != count)
    throw SceneError(scene.file, part, std::to_string(vectors.size()) + " " + what,
                     std::to_string(count) + ", one for each of its vertices");
  for (std::size_t v = 0; v < vectors.size(); ++v)
    for (int k = 0; k < 3; ++k)
      if (!of.holds(vectors[v][k]))
        throw SceneError(scene.file, part + ", vertex " + std::to_string(v), text_of(vectors[v][k]),
                         of.allowed());
}

void check_places(const Scene& scene, const std::string& part, std::size_t count,
                  Span<const Vec3<double>> places) {
  check_vectors(scene, part, count, places, "places", quantity::coordinate);
}

/// @param done what the program does
/// @throws SceneError if the scene has something that plans ahead of its bodies
void check_scene(const Scene& scene, const std::string& part,
                 const char* done = "moved by the program") {
  if (scene.implicit.sleep_distance > 0)
    throw SceneError(scene.file, part, done, "method.implicit.sleep_distance 0 with it");
}

/// @throws SceneError if the scene's meshes may change
void check_meshes_stay(const Scene& scene, const std::string& part, const char* done) {
  if (remeshes(scene) || scene.refinement.when != Refinement::When::never)
    throw SceneError(scene.file, part, done,
                     "a scene that keeps its meshes: neither remeshing nor refine");
}

std::vector<Vec3<double>> start_places(const Scene& scene, const Pin& pin) {
  std::vector<Vec3<double>> places;
  for (const Index v : pin.vertices)
    places.push_back(scene.cloths[at(pin.cloth)].mesh.positions[at(v)] +
                     scene.origin.value_or(Vec3<double>{0, 0, 0}));
  return places;
}

void put(Packer& packer, const LiveShape& shape) {
  const LiveShape::State& s = shape.state();
  packer.put(s.from);
  packer.put(s.to);
  packer.put(s.next);
  packer.put(s.start);
  packer.put(s.end);
}

/// @param count vertices of the shape
LiveShape::State get(Unpacker& unpacker, std::size_t count) {
  LiveShape::State s;
  unpacker.get(s.from);
  unpacker.get(s.to);
  unpacker.get(s.next);
  unpacker.get(s.start);
  unpacker.get(s.end);
  s.moved = true;
  if (s.from.size() != count || s.to.size() != count || (!s.next.empty() && s.next.size() != count))
    unpacker.refuse("has another number of vertices");
  for (const auto* places : {&s.from, &s.to, &s.next})
    for (const Vec3<double>& x : *places)
      for (int k = 0; k < 3; ++k)
        if (!quantity::coordinate.holds(x[k])) unpacker.refuse("has places that cannot be");
  if (!std::isfinite(s.start) || !std::isfinite(s.end))
    unpacker.refuse("has times that are not finite");
  return s;
}

}  // namespace

LiveInputs::LiveInputs(Scene& scene)
    : start_{scene.gravity, scene.wind, {}, {}},
      obstacles_(scene.obstacles.size()),
      pins_(scene.pins.size()),
      forces_(scene.cloths.size()) {
  for (Pin& pin : scene.pins) {
    pin.live = nullptr;
    start_.release_times.push_back(pin.release_time);
  }
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    Obstacle& obstacle = scene.obstacles[o];
    start_.obstacles.emplace_back();
    if (!obstacle.live) continue;
    std::vector<Vec3<double>>& places = start_.obstacles.back();
    places = obstacle.mesh.positions;
    if (obstacle.deformation) obstacle.deformation->positions(0, places);
    for (Vec3<double>& x : places) x = apply(obstacle.transform, x);
    obstacles_[o] = std::make_shared<LiveShape>(places);
    obstacle.mesh.positions = places;
    obstacle.deformation = obstacles_[o];
    obstacle.transform = {};
    check_scene(scene, numbered("obstacles", o) + " (" + obstacle.name + ")");
  }
}

void LiveInputs::move(const Scene& scene, const ObstacleId& id, Span<const Vec3<double>> places) {
  refuse_foreign(scene, id, scene.obstacles.size(), "obstacles");
  const std::size_t o = at(id.index);
  const std::string part = numbered("obstacles", o) + " (" + scene.obstacles[o].name + ")";
  if (!obstacles_[o])
    throw SceneError(scene.file, part, "moved by the program", "an obstacle that is live");
  check_places(scene, part, obstacles_[o]->size(), places);
  obstacles_[o]->move(places);
}

bool LiveInputs::move(Scene& scene, const PinId& id, Span<const Vec3<double>> places) {
  refuse_foreign(scene, id, scene.pins.size(), "pins");
  const std::size_t p = at(id.index);
  const std::string part = numbered("pins", p);
  Pin& pin = scene.pins[p];
  if (!pin.motion.empty() || pin.obstacle >= 0)
    throw SceneError(scene.file, part, "moved by the program",
                     "a pin without a motion and without an obstacle");
  check_meshes_stay(scene, part, "moved by the program");
  check_scene(scene, part);
  check_places(scene, part, pin.vertices.size(), places);
  const bool first = !pins_[p];
  if (first) {
    pins_[p] = std::make_shared<LiveShape>(start_places(scene, pin));
    pin.live = pins_[p];
  }
  pins_[p]->move(places);
  return first;
}

void LiveInputs::set_forces(const Scene& scene, const ClothId& id,
                            Span<const Vec3<double>> forces) {
  refuse_foreign(scene, id, scene.cloths.size(), "cloths");
  const Cloth& cloth = scene.cloths[at(id.index)];
  const std::string part = numbered("cloths", at(id.index)) + " (" + cloth.name + ")";
  const char* done = "forces by the program";
  check_meshes_stay(scene, part, done);
  check_scene(scene, part, done);
  if (scene.method == "asynchronous")
    throw SceneError(scene.file, part, done, "the method \"implicit\"");
  if (!forces.empty())
    check_vectors(scene, part, cloth.mesh.positions.size(), forces, "forces", quantity::force);
  forces_[at(id.index)].assign(forces.begin(), forces.end());
}

std::vector<Vec3<double>> LiveInputs::forces(const Scene& scene) const {
  std::vector<Vec3<double>> all;
  if (!any_forces()) return all;
  for (std::size_t c = 0; c < forces_.size(); ++c) {
    all.insert(all.end(), forces_[c].begin(), forces_[c].end());
    if (forces_[c].empty()) all.resize(all.size() + scene.cloths[c].mesh.positions.size());
  }
  return all;
}

bool LiveInputs::any_forces() const {
  return std::any_of(forces_.begin(), forces_.end(), [](const auto& f) { return !f.empty(); });
}

void LiveInputs::begin_frame(double start, double end) {
  for (const auto* shapes : {&obstacles_, &pins_})
    for (const auto& shape : *shapes)
      if (shape) shape->begin_frame(start, end);
}

bool LiveInputs::changed(const Scene& scene) const {
  const Wind& wind = scene.wind;
  if (scene.gravity != start_.gravity || wind.density != start_.wind.density ||
      wind.velocity != start_.wind.velocity || wind.drag != start_.wind.drag)
    return true;
  for (std::size_t p = 0; p < scene.pins.size(); ++p)
    if (scene.pins[p].release_time != start_.release_times[p] || pins_[p]) return true;
  for (const auto& shape : obstacles_)
    if (shape && shape->state().moved) return true;
  return any_forces();
}

std::string LiveInputs::bytes(const Scene& scene) const {
  if (!changed(scene)) return {};
  Packer packer;
  packer.put(scene.gravity);
  packer.put(scene.wind);
  for (std::size_t p = 0; p < scene.pins.size(); ++p) {
    packer.put(scene.pins[p].release_time);
    packer.put(static_cast<unsigned char>(pins_[p] ? 1 : 0));
    if (pins_[p]) put(packer, *pins_[p]);
  }
  for (const auto& shape : obstacles_)
    if (shape) put(packer, *shape);
  for (const auto& forces : forces_) packer.put(forces);
  return packer.bytes;
}

void LiveInputs::read(const std::string& bytes, const std::string& file, Scene& scene) {
  Vec3<double> gravity = start_.gravity;
  Wind wind = start_.wind;
  std::vector<double> release_times = start_.release_times;
  std::vector<std::optional<LiveShape::State>> pins(scene.pins.size());
  std::vector<std::optional<LiveShape::State>> obstacles(scene.obstacles.size());
  std::vector<std::vector<Vec3<double>>> forces(scene.cloths.size());
  if (!bytes.empty()) {
    Unpacker unpacker(bytes, file, "checkpoint live", "what the program had set");
    unpacker.get(gravity);
    unpacker.get(wind);
    for (int k = 0; k < 3; ++k)
      if (!quantity::acceleration.holds(gravity[k]) || !quantity::velocity.holds(wind.velocity[k]))
        unpacker.refuse("has values that cannot be");
    if (!quantity::air_density.holds(wind.density) || !quantity::drag.holds(wind.drag))
      unpacker.refuse("has values that cannot be");
    for (std::size_t p = 0; p < scene.pins.size(); ++p) {
      unsigned char live = 0;
      unpacker.get(release_times[p]);
      unpacker.get(live);
      if (!(release_times[p] >= 0) || live > 1) unpacker.refuse("has values that cannot be");
      if (live != 0) pins[p] = get(unpacker, scene.pins[p].vertices.size());
    }
    for (std::size_t o = 0; o < scene.obstacles.size(); ++o)
      if (obstacles_[o]) obstacles[o] = get(unpacker, obstacles_[o]->size());
    for (std::size_t c = 0; c < forces.size(); ++c) {
      unpacker.get(forces[c]);
      if (!forces[c].empty() && forces[c].size() != scene.cloths[c].mesh.positions.size())
        unpacker.refuse("has another number of forces");
      for (const Vec3<double>& f : forces[c])
        for (int k = 0; k < 3; ++k)
          if (!quantity::force.holds(f[k])) unpacker.refuse("has forces that cannot be");
    }
    unpacker.end();
  }
  scene.gravity = gravity;
  scene.wind = wind;
  forces_ = std::move(forces);
  for (std::size_t p = 0; p < scene.pins.size(); ++p) {
    scene.pins[p].release_time = release_times[p];
    pins_[p] = nullptr;
    if (pins[p]) {
      pins_[p] = std::make_shared<LiveShape>(pins[p]->to);
      pins_[p]->restore(std::move(*pins[p]));
    }
    scene.pins[p].live = pins_[p];
  }
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    if (!obstacles_[o]) continue;
    // A new one, so that a state that is taken back keeps its own.
    obstacles_[o] = std::make_shared<LiveShape>(start_.obstacles[o]);
    if (obstacles[o]) obstacles_[o]->restore(std::move(*obstacles[o]));
    scene.obstacles[o].deformation = obstacles_[o];
  }
}

}  // namespace weft
