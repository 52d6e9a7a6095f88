#include "host/scene/camera_check.hpp"

#include <cstddef>
#include <cstdio>
#include <string>

#include "host/geometry/box_tree.hpp"
#include "host/scene/camera.hpp"
#include "host/scene/surfaces.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

std::string rounded_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

/// A closed obstacle, as it stands at some time.
class Body {
 public:
  explicit Body(const Obstacle& obstacle) : obstacle_(obstacle) {
    surface_.first_point = surface_.first_triangle = {0};
    surface_.add(obstacle.mesh);
  }

  bool moves() const { return obstacle_.deformation || !obstacle_.motion.empty(); }

  void place(double time) {
    surface_.points = obstacle_.mesh.positions;
    if (obstacle_.deformation)
      obstacle_.deformation->positions(
          time, Span<Vec3<double>>(surface_.points.data(), surface_.points.size()));
    const Transform placed =
        obstacle_.motion.empty() ? obstacle_.transform : transform_at(obstacle_.motion, time);
    around_ = {};
    for (Vec3<double>& x : surface_.points) {
      x = apply(placed, x);
      around_.include(x, x);
    }
  }

  bool holds(const Vec3<double>& x) const {
    return around_.overlaps({x, x}) &&
           winding_number(surface_, 0, static_cast<Index>(surface_.triangles.size()), x) > 0.5;
  }

 private:
  const Obstacle& obstacle_;
  Surfaces surface_;
  Aabb around_;
};

}  // namespace

void refuse_camera_inside(const Scene& scene) {
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    if (!is_closed(scene.obstacles[o].mesh)) continue;
    Body body(scene.obstacles[o]);
    Vec3<double> last{NAN, NAN, NAN};
    for (int frame = 0; frame <= scene.time.frames; ++frame) {
      const double time = frame / scene.time.frame_rate;
      const Vec3<double> eye = camera_at(scene.camera, time).position;
      if (frame == 0 || body.moves())
        body.place(time);
      else if (eye == last)
        continue;
      last = eye;
      if (body.holds(eye))
        throw SceneError(scene.file, "camera.keys",
                         "inside " + title_of(scene, scene.cloths.size() + o) + " at " +
                             rounded_text(time) + " s",
                         "a camera outside of closed obstacles");
    }
  }
}

}  // namespace weft
