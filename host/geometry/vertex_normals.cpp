#include "host/geometry/vertex_normals.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft {
namespace {

Vec3<float> unit(const Vec3<double>& x) {
  // Divided by the largest component first, so that no square overflows or vanishes.
  const double largest = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
  if (!(largest > 0) || !std::isfinite(largest)) return {0, 0, 1};
  const Vec3<double> scaled{x[0] / largest, x[1] / largest, x[2] / largest};
  return vec_cast<float>(scaled * (1.0 / length(scaled)));
}

}  // namespace

std::vector<Vec3<float>> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3<double>> sums(mesh.positions.size(), Vec3<double>{0, 0, 0});
  for (const Tri& tri : mesh.triangles) {
    const auto corner = [&](int k) { return static_cast<std::size_t>(tri.v[k]); };
    const Vec3<double>& x0 = mesh.positions[corner(0)];
    const Vec3<double> twice_area =
        cross(mesh.positions[corner(1)] - x0, mesh.positions[corner(2)] - x0);
    for (int k = 0; k < 3; ++k) sums[corner(k)] += twice_area;
  }
  std::vector<Vec3<float>> normals;
  normals.reserve(sums.size());
  for (const Vec3<double>& sum : sums) normals.push_back(unit(sum));
  return normals;
}

}  // namespace weft
