#include "host/app/render/render_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

#include "host/scene/camera.hpp"
#include "host/view/view_factor.hpp"

namespace weft::app {
namespace {

/// [pixels] of the line between two pictures
constexpr std::size_t gap = 4;

}  // namespace

io::CornerValues view_factor_values(const io::FrameMeshes& meshes, const Scene& scene,
                                    double time) {
  Mesh cloth = io::joined(meshes.cloths), obstacles = io::joined(meshes.obstacles);
  const ViewPlaces places{std::move(cloth.positions), std::move(obstacles.positions)};
  ViewSettings settings = scene.view;
  settings.predict_obstacles = false;
  const ViewField field = look(
      view_instants(scene.camera, settings, scene.time.frame_rate, time),
      make_view_surface(std::move(cloth.triangles), std::move(obstacles.triangles)),
      [&](double) { return places; }, settings);
  io::CornerValues values;
  Index triangle = 0;
  for (const io::NamedMesh& named : meshes.cloths) {
    values.emplace_back();
    for (std::size_t t = 0; t < named.mesh.triangles.size(); ++t)
      values.back().insert(values.back().end(), 3, static_cast<float>(field.factor(triangle++)));
  }
  return values;
}

std::vector<io::Wire> frustum_wires(const Camera& camera, double time, const Vec3<double>& reach) {
  const CameraKey key = camera_at(camera, time);
  const Vec3<double> view = key.look_at - key.position;
  const Vec3<double> forward = (1 / length(view)) * view;
  const Vec3<double> across = cross(forward, key.up);
  const Vec3<double> right = (1 / length(across)) * across;
  const Vec3<double> up = cross(right, forward);
  const double depth = std::max(dot(reach - key.position, forward), 0.1 * length(view));
  const double high = depth * std::tan(key.field_of_view / 2);
  const double wide = high * camera.width / camera.height;
  std::array<Vec3<double>, 4> corners;
  constexpr double sides[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (std::size_t k = 0; k < 4; ++k)
    corners[k] =
        key.position + depth * forward + (sides[k][0] * wide) * right + (sides[k][1] * high) * up;
  std::vector<io::Wire> wires;
  for (std::size_t k = 0; k < 4; ++k) {
    wires.push_back({key.position, corners[k]});
    wires.push_back({corners[k], corners[(k + 1) % 4]});
  }
  return wires;
}

int beside_width(int width) {
  return 2 * width + static_cast<int>(gap);
}

io::Image beside(const io::Image& left, const io::Image& right) {
  io::Image image{beside_width(left.width), left.height, {}};
  const std::size_t a = 3 * static_cast<std::size_t>(left.width);
  const std::size_t b = 3 * static_cast<std::size_t>(right.width);
  for (std::size_t row = 0; row < static_cast<std::size_t>(left.height); ++row) {
    image.rgb.insert(image.rgb.end(), left.rgb.begin() + static_cast<std::ptrdiff_t>(row * a),
                     left.rgb.begin() + static_cast<std::ptrdiff_t>((row + 1) * a));
    image.rgb.insert(image.rgb.end(), 3 * gap, std::uint8_t{255});
    image.rgb.insert(image.rgb.end(), right.rgb.begin() + static_cast<std::ptrdiff_t>(row * b),
                     right.rgb.begin() + static_cast<std::ptrdiff_t>((row + 1) * b));
  }
  return image;
}

}  // namespace weft::app
