#include "host/scene/origin.hpp"

#include <cmath>
#include <vector>

#include "host/geometry/local_origin.hpp"

namespace weft {

Vec3<double> origin_of(const Scene& scene) {
  return scene.origin.value_or(Vec3<double>{0, 0, 0});
}

void choose_origin(Scene& scene) {
  if (scene.origin) return;
  std::vector<const std::vector<Vec3<double>>*> positions;
  for (const Cloth& cloth : scene.cloths) positions.push_back(&cloth.mesh.positions);
  move_origin(scene, local_origin(positions));
}

void move_origin(Scene& scene, const Vec3<double>& origin) {
  const Vec3<double> before = origin_of(scene);
  scene.origin = origin;
  if (origin == before) return;
  const Vec3<double> offset = before - origin;
  for (Cloth& cloth : scene.cloths) {
    move_origin(cloth.mesh.positions, before, origin);
    cloth.velocity_origin += offset;
    // Only differences of rest positions count. They are exact in either place, but a rest shape
    // that does not lie where the cloth starts must not be carried away from (0, 0, 0).
    if (!cloth.rest_positions.empty() &&
        length(cloth.rest_positions[0] + offset) < length(cloth.rest_positions[0]))
      move_origin(cloth.rest_positions, before, origin);
  }
  for (Obstacle& obstacle : scene.obstacles) {
    obstacle.transform.translate += offset;
    for (Keyframe& key : obstacle.motion) key.transform.translate += offset;
    if (obstacle.driven) obstacle.driven->origin += offset;
  }
  for (GarmentStart& start : scene.garment_starts) move_origin(start.apart, before, origin);
  for (Handle& handle : scene.handles) {
    handle.center += offset;
    move_origin(handle.carrier.start, before, origin);
  }
  for (CameraKey& key : scene.camera.keys) {
    key.position += offset;
    key.look_at += offset;
  }
}

Vec3<double> apply_in_world(const Transform& transform, const Vec3<double>& x,
                            const Vec3<double>& origin) {
  if (origin == Vec3<double>{0, 0, 0}) return apply(transform, x);
  // scale * rotate(origin) - origin, from the part of it across the axis: what lies along the axis
  // is not rotated, and its rounding must not count.
  Transform about_origin = transform;
  Vec3<double> moved{0, 0, 0};
  if (transform.rotation_angle != 0) {
    const Vec3<double>& axis = transform.rotation_axis;
    const Vec3<double> across = origin - axis * dot(axis, origin);
    moved = (cross(axis, across) * std::sin(transform.rotation_angle) -
             across * (1 - std::cos(transform.rotation_angle))) *
            transform.scale;
  }
  about_origin.translate += moved + origin * (transform.scale - 1);
  return apply(about_origin, x);
}

}  // namespace weft
