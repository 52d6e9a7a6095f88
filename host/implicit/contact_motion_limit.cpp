#include "host/implicit/contact_motion_limit.hpp"

#include <algorithm>

#include "weft/elements/contact.hpp"

namespace weft {
namespace {

/// [thicknesses] by which rotating obstacles may leave the planes of their contacts in an attempt.
/// With 1, cloth in a drum of 1,000 revolutions a minute still ends in truncated steps.
constexpr double turning_max = 0.5;
/// Edges by which heavily loaded contacts between cloths may slide in an attempt. Chosen in
/// docs/decisions/002-contacts.md.
constexpr double slide_max = 0.5;

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

}  // namespace

template <class T>
void ContactMotionLimit<T>::measure(double dt, const std::vector<Vec3<double>>& placed) {
  measure_turning(dt, placed);
  slide_speed_ = std::max(slide_speed_, detection_.slide() / dt);
}

template <class T>
void ContactMotionLimit<T>::measure_turning(double dt, const std::vector<Vec3<double>>& placed) {
  const Scene& scene = store_.scene();
  const Model& model = store_.model();
  std::vector<Vec3<double>> turned;
  bool any = false;
  for (const Obstacle& obstacle : scene.obstacles) {
    turned.push_back(obstacle.motion.empty()
                         ? Vec3<double>{}
                         : rotation_between(transform_at(obstacle.motion, store_.time),
                                            transform_at(obstacle.motion, store_.time + dt)));
    any = any || length_sq(turned.back()) > 0;
  }
  const Span<const Contact<T>> all = detection_.contacts(0);
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
      bound = std::max(bound, length(placed[i] - placed_before_[i]) * sine / 2);
  }
  if (bound <= turning_max * contact_thickness(scene.contact)) return;
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
      moved += static_cast<double>(c.w[j]) * (placed[i] - placed_before_[i]);
    }
    if (last < 0) continue;
    const auto next =
        std::upper_bound(model.obstacle_offset.begin(), model.obstacle_offset.end(), last);
    const auto obstacle = static_cast<std::size_t>(next - model.obstacle_offset.begin() - 1);
    turning_acceleration_ =
        std::max(turning_acceleration_, length(tangential(moved, n)) *
                                            length(tangential(turned[obstacle], n)) / (dt * dt));
  }
}

template <class T>
bool ContactMotionLimit<T>::exceeded_in(double dt) const {
  return turning_acceleration_ * dt * dt / 2 >
             turning_max * contact_thickness(store_.scene().contact) ||
         slide_speed_ * dt > slide_max;
}

template class ContactMotionLimit<float>;
template class ContactMotionLimit<double>;

}  // namespace weft
