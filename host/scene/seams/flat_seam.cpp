#include "host/scene/seams/flat_seam.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Share of the cloth's size by which it may leave its plane and still be flat.
constexpr double flat_height = 0.01;
/// Share of the cloth's extent along a seam's pull from which the pull crushes it: less gathers it.
constexpr double least_pull = 0.5;
/// Share of an angle's sine that rounding may take.
constexpr double rounding = 1e-6;

/// Sum of the triangles' normals, as long as twice their area.
Vec3<double> normal_of(const std::vector<Tri>& triangles, const std::vector<Vec3<double>>& x) {
  Vec3<double> normal{0, 0, 0};
  for (const Tri& t : triangles)
    normal = normal + cross(x[at(t.v[1])] - x[at(t.v[0])], x[at(t.v[2])] - x[at(t.v[0])]);
  return normal;
}

double extent(const std::vector<Vec3<double>>& x, const Vec3<double>& direction) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3<double>& p : x) {
    const double along = dot(p, direction);
    low = std::min(low, along);
    high = std::max(high, along);
  }
  return high - low;
}

bool is_flat(const std::vector<Vec3<double>>& x, const Vec3<double>& normal) {
  double size = 0;
  for (int k = 0; k < 3; ++k) {
    Vec3<double> axis{0, 0, 0};
    axis[k] = 1;
    size = std::max(size, extent(x, axis));
  }
  const double twice_area = length(normal);
  return twice_area > 0 && extent(x, normal * (1 / twice_area)) <= flat_height * size;
}

/// Whether a triangle holds the directions next to `pull` at one of its corners.
bool holds(const Vec3<double>& corner, const Vec3<double>& right, const Vec3<double>& left,
           const Vec3<double>& pull, const Vec3<double>& normal) {
  const auto turn = [&](const Vec3<double>& a, const Vec3<double>& b) {
    return dot(cross(a, b), normal) >= -rounding * length(a) * length(b) * length(normal);
  };
  return turn(right - corner, pull) && turn(pull, left - corner);
}

}  // namespace

bool crushes_flat_cloth(const Cloth& cloth, const Seam& seam) {
  if (seam.cloths[0] != seam.cloths[1] || seam.vertices[0].empty()) return false;
  if (seam.start_time > 0) return false;  // gravity and bodies may bend it by then
  const std::vector<Vec3<double>>& x = cloth.mesh.positions;
  const Vec3<double> normal = normal_of(cloth.mesh.triangles, x);
  if (!is_flat(x, normal)) return false;
  if (!cloth.rest_positions.empty() &&
      !is_flat(cloth.rest_positions, normal_of(cloth.mesh.triangles, cloth.rest_positions)))
    return false;

  const std::size_t pairs = seam.vertices[0].size();
  Vec3<double> mean{0, 0, 0};
  std::vector<Vec3<double>> pull(x.size(), Vec3<double>{0, 0, 0});
  for (std::size_t k = 0; k < pairs; ++k) {
    const Index v = seam.vertices[0][k], w = seam.vertices[1][k];
    const Vec3<double> gap = x[at(w)] - x[at(v)];
    mean = mean + gap * (1 / static_cast<double>(pairs));
    pull[at(v)] = gap;
    pull[at(w)] = gap * -1.0;
  }
  const double distance = length(mean);
  if (!(distance > 0) || distance < least_pull * extent(x, mean * (1 / distance))) return false;

  std::vector<bool> inwards(x.size(), false);
  for (const Tri& t : cloth.mesh.triangles)
    for (int j = 0; j < 3; ++j) {
      const Index v = t.v[j];
      if (length(pull[at(v)]) > 0 &&
          holds(x[at(v)], x[at(t.v[(j + 1) % 3])], x[at(t.v[(j + 2) % 3])], pull[at(v)], normal))
        inwards[at(v)] = true;
    }
  std::size_t crushing = 0;
  for (std::size_t k = 0; k < pairs; ++k)
    if (inwards[at(seam.vertices[0][k])] && inwards[at(seam.vertices[1][k])]) ++crushing;
  return 2 * crushing > pairs;
}

}  // namespace weft
