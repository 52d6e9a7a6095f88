#include "host/asynchronous/prescribed.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cmath>

namespace weft {
Prescribed::Prescribed(const Scene& scene, const Model& model, const std::vector<Index>& place)
    : scene_(scene), model_(model), place_(place) {
  for (const Obstacle& obstacle : scene.obstacles) changes_ = changes_ || obstacle_moves(obstacle);
  for (const Pin& pin : scene.pins) {
    changes_ = changes_ || !pin.motion.empty() || (pin.obstacle >= 0 && !driven(pin));
    if (std::isfinite(pin.release_time)) release_times_.push_back(pin.release_time);
  }
  std::sort(release_times_.begin(), release_times_.end());
  release_times_.erase(std::unique(release_times_.begin(), release_times_.end()),
                       release_times_.end());
  changes_ = changes_ || !release_times_.empty();
}

bool Prescribed::driven(const Pin& pin) const {
  return pin.obstacle >= 0 && scene_.obstacles[at(pin.obstacle)].driven;
}

std::size_t Prescribed::phase(double time) const {
  return static_cast<std::size_t>(
      std::upper_bound(release_times_.begin(), release_times_.end(), time) -
      release_times_.begin());
}

void Prescribed::go(Index model_vertex, const Vec3<double>& to, double now, double next,
                    VertexMotion& motion, Histories* histories) const {
  const std::size_t i = at(place_[at(model_vertex)]);
  motion.advance(i, now);
  if (histories != nullptr) histories->add(i, now, motion.x[i]);
  motion.v[i] = (to - motion.x[i]) * (1 / (next - now));
}

void Prescribed::aim(double now, double next, VertexMotion& motion, Histories* histories) {
  place_obstacles(scene_, model_, next, placed_);
  for (std::size_t k = 0; k < placed_.size(); ++k)
    if (obstacle_moves(scene_.obstacles[at(model_.obstacle_of_vertex[k])]))
      go(model_.cloth_vertex_count + static_cast<Index>(k), placed_[k], now, next, motion,
         histories);
  for (const Model::PinnedVertex& pinned : model_.pinned) {
    const Pin& pin = scene_.pins[at(pinned.pin)];
    if (pin_holds(pin, now) && driven(pin)) continue;
    if (pin_holds(pin, now))
      go(pinned.vertex, pinned_position(scene_, pinned, next, placed_), now, next, motion,
         histories);
    else
      motion.inv_mass[at(place_[at(pinned.vertex)])] = 1 / model_.mass[at(pinned.vertex)];
  }
}

}  // namespace weft
