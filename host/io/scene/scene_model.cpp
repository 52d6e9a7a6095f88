
#include "host/io/scene/scene_parts.hpp"

namespace weft::io {
namespace {

void leave_out_bending(Scene& scene) {
  for (Material& material : scene.materials) {
    material.bending_stiffness = 0;
    if (material.orthotropic_bending) material.orthotropic_bending = OrthotropicBending{0, 0, 0, 0};
  }
}

void leave_out_friction(Scene& scene) {
  scene.contact.friction = 0;
  for (Obstacle& obstacle : scene.obstacles) obstacle.friction = 0;
}

/// Obstacles stay as they are at time 0.
void freeze_obstacles(Scene& scene) {
  for (Obstacle& obstacle : scene.obstacles) {
    if (!obstacle.motion.empty()) obstacle.transform = transform_at(obstacle.motion, 0);
    obstacle.motion.clear();
    obstacle.driven.reset();
    obstacle.deformation.reset();  // the mesh is its shape at time 0
  }
}

}  // namespace

void read_model(Fields& root, Scene& scene) {
  Fields fields = root.object("model", {"bending", "friction", "obstacle_motion"});
  if (!fields.boolean("bending", true)) leave_out_bending(scene);
  if (!fields.boolean("friction", true)) leave_out_friction(scene);
  if (!fields.boolean("obstacle_motion", true)) freeze_obstacles(scene);
}

}  // namespace weft::io
