#include <numbers>
#include <utility>
#include <vector>

#include "host/io/scene/scene_parts.hpp"
#include "host/render/picture.hpp"

namespace weft::io {
namespace {

/// Instants at which the obstacles of a run are looked at.
constexpr int instants = 9;

Mesh placed(const Obstacle& obstacle, double time) {
  Mesh mesh = obstacle.mesh;
  if (obstacle.deformation)
    obstacle.deformation->positions(
        time, Span<Vec3<double>>(mesh.positions.data(), mesh.positions.size()));
  const Transform transform =
      obstacle.motion.empty() ? obstacle.transform : transform_at(obstacle.motion, time);
  for (Vec3<double>& x : mesh.positions) x = apply(transform, x);
  return mesh;
}

}  // namespace

CameraKey framing_camera(const Scene& scene) {
  std::vector<NamedMesh> cloths, obstacles;
  for (const Cloth& cloth : scene.cloths) cloths.push_back({cloth.name, cloth.mesh});
  PictureOptions options;
  options.width = scene.camera.width;
  options.height = scene.camera.height;
  options.vertical_field_of_view_degrees = 40;
  options = upright(options, scene.gravity);
  PictureSubject subject;
  for (int k = 0; k < instants; ++k) {
    const double time = scene.time.frames / scene.time.frame_rate * k / (instants - 1);
    obstacles.clear();
    for (const Obstacle& obstacle : scene.obstacles)
      obstacles.push_back({obstacle.name, placed(obstacle, time)});
    add_to_subject(subject, cloths, obstacles);
  }
  options.subject = std::move(subject);
  options = frame_camera(cloths, obstacles, options);
  CameraKey key;
  key.position = options.eye;
  key.look_at = options.look_at;
  key.up = options.up;
  key.field_of_view = options.vertical_field_of_view_degrees * std::numbers::pi / 180;
  return key;
}

}  // namespace weft::io
