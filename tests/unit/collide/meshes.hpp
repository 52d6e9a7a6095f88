#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "host/implicit/contact/swept_mesh.hpp"
#include "weft/shapes.hpp"

namespace weft::test {

using Points = std::vector<Vec3<double>>;

/// Numbers that are the same on every machine.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_()) / 4294967295.0;
  }
  Vec3<double> within(double half) {
    return {uniform(-half, half), uniform(-half, half), uniform(-half, half)};
  }

 private:
  std::mt19937 engine_;
};

/// A grid of cells x cells quads of side `edge`, as `shape` bends it, moved by up to `motion`.
inline SweptMesh sheet(int cells, double edge, double motion, Random& random,
                       const std::function<Vec3<double>(double, double)>& shape) {
  const Mesh grid = make_grid({edge * cells, edge * cells}, {cells, cells}, Diagonals::alternating);
  Points from, to;
  for (const auto& p : grid.positions) {
    from.push_back(shape(p[0], p[1]));
    to.push_back(from.back() + random.within(motion));
  }
  return make_swept_mesh(from, to, grid.triangles);
}

/// Triangles that share no vertex.
inline SweptMesh soup(
    int count, Random& random,
    const std::function<void(int, Random&, Vec3<double> (&)[3], Vec3<double> (&)[3])>& place) {
  Points from, to;
  std::vector<Tri> triangles;
  for (int k = 0; k < count; ++k) {
    Vec3<double> x[3], y[3];
    place(k, random, x, y);
    const auto first = static_cast<Index>(from.size());
    triangles.push_back({{first, first + 1, first + 2}});
    for (int j = 0; j < 3; ++j) {
      from.push_back(x[j]);
      to.push_back(y[j]);
    }
  }
  return make_swept_mesh(from, to, triangles);
}

/// Obstacle after cloth: vertices, faces and edges.
inline SweptMesh joined(const SweptMesh& cloth, const SweptMesh& obstacle) {
  SweptMesh both = cloth;
  const Index first = cloth.counts.vertices;
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(both.positions_t0, obstacle.positions_t0);
  append(both.positions_t1, obstacle.positions_t1);
  for (const Tri& t : obstacle.triangles)
    both.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  for (const Edge& e : obstacle.edges) both.edges.push_back({{first + e.v[0], first + e.v[1]}});
  both.counts.vertices += obstacle.counts.vertices;
  both.counts.triangles += obstacle.counts.triangles;
  both.counts.edges += obstacle.counts.edges;
  return both;
}

}  // namespace weft::test
