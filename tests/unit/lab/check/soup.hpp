#pragma once

#include <initializer_list>
#include <vector>

#include "weft/scene.hpp"

/// Small meshes for the tests of the validator.
namespace weft::lab::test {

using Points = std::vector<Vec3<double>>;

/// A mesh of the given triangles over the given points.
inline Mesh mesh_of(Points points, std::vector<Tri> triangles) {
  Mesh mesh;
  mesh.positions = std::move(points);
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// Square sheet of n x n cells with material coordinates (u, v) in [0, 1]^2, placed by f(u, v).
template <class F>
Mesh sheet(int n, F&& f) {
  Mesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const Vec2<double> uv{double(i) / n, double(j) / n};
      mesh.material.push_back(uv);
      mesh.positions.push_back(f(uv[0], uv[1]));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({{a, b, d}});
      mesh.triangles.push_back({{a, d, c}});
    }
  return mesh;
}

/// Appends `other` to `mesh` as a separate part.
inline void append(Mesh& mesh, const Mesh& other) {
  const auto offset = static_cast<Index>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.material.insert(mesh.material.end(), other.material.begin(), other.material.end());
  for (Tri t : other.triangles) {
    for (Index& v : t.v) v += offset;
    mesh.triangles.push_back(t);
  }
}

}  // namespace weft::lab::test
