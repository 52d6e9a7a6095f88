#include "host/scene/lift.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

#include "host/geometry/box_tree.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "host/scene/inside_obstacle.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

constexpr int bisections = 10;

/// A cloth that can be tried at other places.
class LiftedCloth {
 public:
  LiftedCloth(const Scene& scene, const Surfaces& surfaces, std::size_t cloth,
              const Vec3<double>& direction)
      : scene_(scene),
        surfaces_(surfaces),
        cloth_(cloth),
        direction_(direction),
        obstacle_(surfaces.points, surfaces.triangles, surfaces.first_triangle[scene.cloths.size()],
                  surfaces.first_triangle.back(), touching) {}

  /// Lifts beyond this leave nothing to meet. [m]
  double largest() const {
    Aabb all;
    for (const Vec3<double>& x : surfaces_.points) all.include(x, x);
    return length(all.hi - all.lo);
  }

  bool is_clear(double distance) const {
    const Vec3<double> offset = distance * direction_;
    std::vector<Vec3<double>> points = surfaces_.points;
    for (Index v = surfaces_.first_point[cloth_]; v < surfaces_.first_point[cloth_ + 1]; ++v)
      points[at(v)] += offset;
    const BoxTree own(points, surfaces_.triangles, surfaces_.first_triangle[cloth_],
                      surfaces_.first_triangle[cloth_ + 1], touching);
    const auto corners = [&](const Tri& t) {
      return Corners{points[at(t.v[0])], points[at(t.v[1])], points[at(t.v[2])]};
    };
    bool clear = true;
    const auto visit = [&](Index a, Index b) {
      const Tri& s = surfaces_.triangles[at(a)];
      const Tri& t = surfaces_.triangles[at(b)];
      clear = clear && !triangles_intersect(s, t, corners(s), corners(t));
    };
    visit_pairs(own, 1, obstacle_, 1, visit);
    return clear && !part_inside_obstacle(scene_, surfaces_, cloth_, offset);
  }

 private:
  const Scene& scene_;
  const Surfaces& surfaces_;
  std::size_t cloth_;
  Vec3<double> direction_;
  BoxTree obstacle_;
};

/// To three digits.
double rounded(double x, double& unit) {
  unit = std::pow(10, std::floor(std::log10(x)) - 2);
  return std::round(x / unit) * unit;
}

}  // namespace

std::optional<Lift> lift_clear(const Scene& scene, const Surfaces& surfaces, std::size_t cloth) {
  const double g = length(scene.gravity);
  const Vec3<double> up = g > 0 ? (-1 / g) * scene.gravity : Vec3<double>{0, 0, 1};
  const LiftedCloth lifted(scene, surfaces, cloth, up);
  const double thickness = contact_thickness(scene.contact);
  const double largest = lifted.largest() + thickness;
  double low = 0;
  double high = thickness;
  while (!lifted.is_clear(high)) {
    if (high > largest) return std::nullopt;
    low = high;
    high *= 2;
  }
  for (int k = 0; k < bisections; ++k) {
    const double middle = (low + high) / 2;
    (lifted.is_clear(middle) ? high : low) = middle;
  }
  double unit = 0;
  for (const double wanted : {high + thickness, high}) {
    const double distance = rounded(wanted, unit);
    for (const double tried : {distance, distance + unit})
      if (lifted.is_clear(tried)) return Lift{up, tried};
  }
  return Lift{up, high};
}

}  // namespace weft
