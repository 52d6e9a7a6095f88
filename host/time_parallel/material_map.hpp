#pragma once

#include <array>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Where the vertices of one mesh lie in the triangles of another, in material space.
struct MaterialMap {
  std::vector<std::array<Index, 3>> corner;   ///< [vertices] corners of the triangle, in the other
  std::vector<std::array<double, 3>> weight;  ///< [vertices] sum 1; outside of it: beyond 0 to 1
};

/// Finds for every vertex the triangle of `on` that holds its material point, or the nearest one,
/// whose plane then goes on beyond it. Where pieces of a pattern lie on top of each other in
/// material space, the one counts whose positions are nearest.
/// @pre both meshes have material coordinates, and `on` has triangles
MaterialMap map_material(const Mesh& mesh, const Mesh& on);

/// Values of the other mesh's vertices, linear over its triangles, at the mapped ones.
template <class V>
std::vector<V> interpolated(const MaterialMap& map, const V* values) {
  std::vector<V> result;
  result.reserve(map.corner.size());
  for (std::size_t i = 0; i < map.corner.size(); ++i) {
    V sum{};
    for (std::size_t k = 0; k < 3; ++k)
      if (map.weight[i][k] != 0)
        sum += map.weight[i][k] * values[static_cast<std::size_t>(map.corner[i][k])];
    result.push_back(sum);
  }
  return result;
}

}  // namespace weft
