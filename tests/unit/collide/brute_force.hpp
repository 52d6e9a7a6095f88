#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "host/implicit/contact/swept_mesh.hpp"

namespace weft::test {

using Pairs = std::vector<std::pair<Index, Index>>;

/// Every pair of primitives that share no vertex and whose swept boxes, grown by `inflate`, meet,
/// by comparing all with all in long double; or, if `split`, of which along no axis one lies below
/// the other at the start and at the end. Shares nothing with the code under test.
struct BruteForce {
  Pairs face_pairs;  ///< vertex, face; ascending
  Pairs edge_pairs;  ///< edge, later edge; ascending
};

inline BruteForce brute_force(const SweptMesh& mesh, double inflate, bool split = false) {
  using Long = long double;
  struct Extent {  // of the start, and of the end
    Long lo[2][3], hi[2][3];
  };
  const auto extent = [&](const Index* v, int corners) {
    Extent e;
    for (int c = 0; c < 3; ++c) {
      for (int end = 0; end < 2; ++end) {
        const auto& x = end == 0 ? mesh.positions_t0 : mesh.positions_t1;
        e.lo[end][c] = e.hi[end][c] = x[static_cast<std::size_t>(v[0])][c];
        for (int j = 1; j < corners; ++j) {
          const Long at = x[static_cast<std::size_t>(v[j])][c];
          e.lo[end][c] = std::min(e.lo[end][c], at);
          e.hi[end][c] = std::max(e.hi[end][c], at);
        }
        e.lo[end][c] -= static_cast<Long>(inflate);
        e.hi[end][c] += static_cast<Long>(inflate);
      }
      if (split) continue;
      for (int end = 0; end < 2; ++end) {
        e.lo[end][c] = std::min(e.lo[0][c], e.lo[1][c]);
        e.hi[end][c] = std::max(e.hi[0][c], e.hi[1][c]);
      }
    }
    return e;
  };
  const auto meet = [](const Extent& a, const Extent& b) {
    for (int c = 0; c < 3; ++c) {
      if (a.hi[0][c] < b.lo[0][c] && a.hi[1][c] < b.lo[1][c]) return false;
      if (b.hi[0][c] < a.lo[0][c] && b.hi[1][c] < a.lo[1][c]) return false;
    }
    return true;
  };
  std::vector<Extent> vertices, faces, edges;
  for (Index v = 0; v < mesh.counts.vertices; ++v) vertices.push_back(extent(&v, 1));
  for (const Tri& t : mesh.triangles) faces.push_back(extent(t.v, 3));
  for (const Edge& e : mesh.edges) edges.push_back(extent(e.v, 2));
  BruteForce found;
  const PrimitiveCounts& n = mesh.counts;
  for (Index v = 0; v < n.vertices; ++v)
    for (Index f = 0; f < n.triangles; ++f) {
      const Index* t = mesh.triangles[static_cast<std::size_t>(f)].v;
      if (t[0] == v || t[1] == v || t[2] == v) continue;
      if (v >= n.cloth_vertices && f >= n.cloth_triangles) continue;
      if (meet(vertices[static_cast<std::size_t>(v)], faces[static_cast<std::size_t>(f)]))
        found.face_pairs.emplace_back(v, f);
    }
  for (Index e = 0; e < n.cloth_edges; ++e)
    for (Index f = e + 1; f < n.edges; ++f) {
      const Index* p = mesh.edges[static_cast<std::size_t>(e)].v;
      const Index* q = mesh.edges[static_cast<std::size_t>(f)].v;
      if (p[0] == q[0] || p[0] == q[1] || p[1] == q[0] || p[1] == q[1]) continue;
      if (meet(edges[static_cast<std::size_t>(e)], edges[static_cast<std::size_t>(f)]))
        found.edge_pairs.emplace_back(e, f);
    }
  return found;
}

inline Pairs numbers_of(const std::vector<Pair>& pairs) {
  Pairs all;
  all.reserve(pairs.size());
  for (const Pair& p : pairs) all.emplace_back(p.a, p.b);
  return all;
}

}  // namespace weft::test
