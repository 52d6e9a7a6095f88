#include "host/asynchronous/driven.hpp"

#include "weft/core/at.hpp"

namespace weft {
DrivenBodies::DrivenBodies(const Scene& scene, const Model& model, const std::vector<Index>& place)
    : scene_(scene) {
  std::vector<Index> body_of(scene.obstacles.size(), -1);
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o)
    if (scene.obstacles[o].driven) {
      body_of[o] = static_cast<Index>(bodies_.size());
      bodies_.push_back(o);
    }
  if (bodies_.empty()) return;
  carrier_.assign(place.size(), -1);
  const auto add = [&](Index vertex, Index b, double mass) {
    if (b < 0) return;
    const Vec3<double> start = model.positions[at(vertex)] - body(at(b)).origin;
    const std::size_t here = at(place[at(vertex)]);
    carrier_[here] = b;
    carried_.push_back(
        {here, at(b), start, mass, mass * length_sq(cross(body(at(b)).axis, start))});
  };
  for (std::size_t k = 0; k < model.obstacle_of_vertex.size(); ++k)
    add(model.cloth_vertex_count + static_cast<Index>(k), body_of[at(model.obstacle_of_vertex[k])],
        0);
  for (const Model::PinnedVertex& pinned : model.pinned) {
    const Pin& pin = scene.pins[at(pinned.pin)];
    if (pin.obstacle >= 0)
      add(pinned.vertex, body_of[at(pin.obstacle)], model.mass[at(pinned.vertex)]);
  }
}

void DrivenBodies::begin(const std::vector<double>& state, VertexMotion& motion) const {
  motion.carrier = carrier_;
  motion.bodies.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    motion.bodies.push_back({body(b).origin, body(b).axis});
    if (state.size() != 3 * bodies_.size()) continue;
    motion.bodies[b].angle = state[3 * b];
    motion.bodies[b].speed = state[3 * b + 1];
    motion.bodies[b].impulse = state[3 * b + 2];
  }
}

std::vector<double> DrivenBodies::state_of(const VertexMotion& motion) {
  std::vector<double> state;
  for (const BodyMotion& body : motion.bodies)
    state.insert(state.end(), {body.angle, body.speed, body.impulse});
  return state;
}

void DrivenBodies::turn(double now, double next, double h, VertexMotion& motion) const {
  std::vector<double> inertia;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    inertia.push_back(body(b).inertia);
    if (now >= body(b).start_time && now < body(b).end_time)
      motion.bodies[b].impulse += body(b).torque * h;
  }
  for (const Carried& c : carried_) {
    // A pin that has let go keeps its share of what it turned with.
    if (c.mass == 0 || motion.inv_mass[c.place] > 0) continue;
    inertia[c.body] += c.inertia;
    motion.push_carrier(c.place, now, scene_.gravity * (h * c.mass));
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    BodyMotion& turning = motion.bodies[b];
    turning.speed += turning.impulse / inertia[b];
    turning.impulse = 0;
    turning.angle += turning.speed * (next - now);
  }
}

void DrivenBodies::carry(double now, double next, VertexMotion& motion,
                         Histories* histories) const {
  for (const Carried& c : carried_) {
    if (motion.inv_mass[c.place] > 0) continue;
    const BodyMotion& turning = motion.bodies[c.body];
    Transform turned;
    turned.translate = turning.origin;
    turned.rotation_axis = turning.axis;
    turned.rotation_angle = turning.angle;
    motion.advance(c.place, now);
    if (histories != nullptr) histories->add(c.place, now, motion.x[c.place]);
    motion.v[c.place] = (apply(turned, c.start) - motion.x[c.place]) * (1 / (next - now));
  }
}

}  // namespace weft
