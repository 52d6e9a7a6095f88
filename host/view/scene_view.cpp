#include "host/view/scene_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "host/geometry/attachment.hpp"
#include "host/geometry/box_forest.hpp"
#include "host/scene/camera.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/view/compensation.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Cloth that moves along with obstacles for as long as a camera looks ahead.
class Companions {
 public:
  /// @param reach [m] cloth farther from obstacles stays
  Companions(const ViewSurface& surface, const ViewPlaces& now, double reach) {
    std::vector<Aabb> boxes;
    for (const Tri& t : surface.obstacles) {
      boxes.emplace_back();
      for (const Index v : t.v) boxes.back().include(now.obstacles[at(v)], now.obstacles[at(v)]);
    }
    const BoxForest forest(boxes);
    const Vec3<double> by{reach, reach, reach};
    for (std::size_t v = 0; v < now.cloth.size(); ++v) {
      Aabb box;
      box.include(now.cloth[v] - by, now.cloth[v] + by);
      std::vector<Index> near;
      forest.overlapping(box, [&](Index t) { near.push_back(t); });
      std::sort(near.begin(), near.end());
      std::vector<Tri> triangles;
      for (const Index t : near) triangles.push_back(surface.obstacles[at(t)]);
      if (triangles.empty()) continue;
      const Attachment found =
          attach({now.cloth[v]}, {triangles.data(), triangles.size()}, span_of(now.obstacles))[0];
      if (length(found.offset) <= reach) carried_.push_back({v, found});
    }
  }

  void carry(ViewPlaces& places) const {
    for (const auto& [v, attachment] : carried_)
      places.cloth[v] = attached_position(attachment, span_of(places.obstacles));
  }

 private:
  static Span<const Vec3<double>> span_of(const std::vector<Vec3<double>>& all) {
    return {all.data(), all.size()};
  }
  std::vector<std::pair<std::size_t, Attachment>> carried_;
};

double material_area(const Mesh& mesh, std::size_t triangle) {
  const Tri& c = mesh.material_triangles.empty() ? mesh.triangles[triangle]
                                                 : mesh.material_triangles[triangle];
  const Vec2<double> a = mesh.material[at(c.v[1])] - mesh.material[at(c.v[0])];
  const Vec2<double> b = mesh.material[at(c.v[2])] - mesh.material[at(c.v[0])];
  return (a[0] * b[1] - a[1] * b[0]) / 2;
}

double equilateral_area(double edge) {
  return std::sqrt(3.0) / 4 * edge * edge;
}

}  // namespace

ViewSurface scene_surface(const Scene& scene) {
  const std::vector<Index> offsets = input_offsets(scene);
  std::vector<Tri> triangles, obstacles;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    for (Tri t : scene.cloths[c].mesh.triangles) {
      for (Index& v : t.v) v += offsets[c];
      triangles.push_back(t);
    }
  Index first = 0;
  for (const Obstacle& obstacle : scene.obstacles) {
    for (Tri t : obstacle.mesh.triangles) {
      for (Index& v : t.v) v += first;
      obstacles.push_back(t);
    }
    first += static_cast<Index>(obstacle.mesh.positions.size());
  }
  return make_view_surface(std::move(triangles), std::move(obstacles));
}

ViewField look_at_scene(const Scene& scene, const Model& model, const ViewSurface& surface,
                        const ViewPlaces& now, double time) {
  const auto instants = view_instants(scene.camera, scene.view, scene.time.frame_rate, time);
  if (!scene.view.predict_obstacles || surface.obstacles.empty())
    return look(
        instants, surface, [&](double) { return now; }, scene.view);
  const Companions companions(surface, now, scene.view.margin);
  const auto places_at = [&](double delay) {
    ViewPlaces places = now;
    if (delay > 0) {
      places.obstacles.clear();
      place_obstacles(scene, model, time + delay, places.obstacles);
      companions.carry(places);
    }
    return places;
  };
  return look(instants, surface, places_at, scene.view);
}

SceneView evaluate_view(const Scene& scene, const ViewSurface& surface, const ViewPlaces& now,
                        double time) {
  const ViewCamera camera(camera_at(scene.camera, time), scene.camera.width, scene.camera.height);
  std::vector<double> areas;
  std::vector<AreaRange> ranges;
  for (const Cloth& cloth : scene.cloths) {
    const Remeshing& sizes = *cloth.remeshing;
    const AreaRange range{equilateral_area(sizes.size_min), equilateral_area(sizes.size_max)};
    ranges.insert(ranges.end(), cloth.mesh.triangles.size(), range);
    for (std::size_t t = 0; t < cloth.mesh.triangles.size(); ++t)
      areas.push_back(material_area(cloth.mesh, t));
  }
  SceneView view;
  view.compression =
      compression_shares(areas, ranges, out_of_frustum(camera, surface, now), scene.view);
  const std::vector<double> factors = view_factors(camera, surface, now, scene.view);
  double area = 0;
  for (std::size_t t = 0; t < factors.size(); ++t) {
    area += areas[t];
    view.factor_mean += areas[t] * factors[t];
    if (factors[t] == 1) ++view.in_view;
  }
  view.factor_mean /= area;
  return view;
}

}  // namespace weft
