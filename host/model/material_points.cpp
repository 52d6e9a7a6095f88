#include "host/model/material_points.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

namespace weft {
namespace {

/// Material coordinates with the pieces of a pattern side by side: pieces that lie on each other in
/// the file, such as front and back, are not near each other in the cloth.
std::vector<Vec2<double>> spread_pieces(const Mesh& mesh) {
  std::vector<Index> parent(mesh.material.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Index i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      Index& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  for (const Tri& t : mesh.material_triangles)
    for (int j = 1; j < 3; ++j) {
      const Index a = root(t.v[0]);
      const Index b = root(t.v[j]);
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  std::vector<double> low(mesh.material.size(), std::numeric_limits<double>::infinity());
  std::vector<double> high(mesh.material.size(), -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < mesh.material.size(); ++i) {
    const auto piece = static_cast<std::size_t>(root(static_cast<Index>(i)));
    low[piece] = std::min(low[piece], mesh.material[i][0]);
    high[piece] = std::max(high[piece], mesh.material[i][0]);
  }
  // The gap is as wide as the piece before it: more than any contact reaches.
  std::vector<double> shift(mesh.material.size(), 0);
  double next = 0;
  for (std::size_t i = 0; i < shift.size(); ++i) {
    if (parent[i] != static_cast<Index>(i) || !(high[i] > low[i])) continue;
    shift[i] = next - low[i];
    next += 2 * (high[i] - low[i]);
  }
  std::vector<Vec2<double>> result = mesh.material;
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i][0] += shift[static_cast<std::size_t>(root(static_cast<Index>(i)))];
  return result;
}

}  // namespace

void append_material_points(const Mesh& mesh, std::vector<Vec2<double>>& points) {
  if (mesh.material_triangles.empty()) {
    points.insert(points.end(), mesh.material.begin(), mesh.material.end());
    return;
  }
  const std::vector<Vec2<double>> material = spread_pieces(mesh);
  const std::size_t first = points.size();
  points.resize(first + mesh.positions.size());
  std::vector<bool> known(mesh.positions.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int j = 0; j < 3; ++j) {
      const auto v = static_cast<std::size_t>(mesh.triangles[t].v[j]);
      if (known[v]) continue;
      known[v] = true;
      points[first + v] = material[static_cast<std::size_t>(mesh.material_triangles[t].v[j])];
    }
}

std::array<Vec2<double>, 3> material_corners(const Mesh& mesh, std::size_t triangle) {
  const Tri& t = mesh.material_triangles.empty() ? mesh.triangles[triangle]
                                                 : mesh.material_triangles[triangle];
  std::array<Vec2<double>, 3> corners;
  for (std::size_t j = 0; j < 3; ++j) corners[j] = mesh.material[static_cast<std::size_t>(t.v[j])];
  return corners;
}

}  // namespace weft
