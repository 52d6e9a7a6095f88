#pragma once

#include <map>
#include <utility>

#include "tests/parity/support.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/state/surface.hpp"

namespace weft::parity {

/// Two crumpled sheets of cloth and one of an obstacle, one above the other and so close that they
/// pass through each other as they move; every pair of primitives whose swept boxes nearly meet, by
/// comparing all with all; and how their faces hang together.
template <class T>
struct Layers {
  static constexpr double gap = 0.03, motion = 0.012, thickness = 0.01, grown = 0.004;
  Random random;
  Index cloth = 0;  ///< number of the cloth's vertices
  std::vector<Vec3<T>> positions_t0, positions_t1;
  std::vector<Tri> triangles, edges_of_face;
  std::vector<Edge> edges;
  std::vector<EdgeWings> wings;
  std::vector<Offset> ring_offset;
  std::vector<Index> ring, face_of_vertex, cloth_of_vertex;
  std::vector<Vec2<T>> material;  ///< [cloth vertices]
  std::vector<Pair> face_pairs, edge_pairs;

  explicit Layers(std::uint32_t seed) : random(seed) {
    for (int layer = 0; layer < 3; ++layer) add_sheet(layer);
    for (const Vec3<T>& x : positions_t0)
      positions_t1.push_back(x + random.vector<T>(-motion, motion));
    list_edges();
    list_rings();
    list_pairs();
  }

  std::size_t vertex_count() const { return positions_t0.size(); }

 private:
  void add_sheet(int layer) {
    const Sheet<T> sheet(random);
    const auto first = static_cast<Index>(positions_t0.size());
    for (const Vec3<T>& x : sheet.positions) {
      const T height = static_cast<T>(static_cast<float>(gap * layer));
      positions_t0.push_back({x[0], x[1], x[2] + height});
      if (layer < 2) {
        // At rest the second one goes on where the first one begins, after a narrow gap.
        const auto number = static_cast<int>(&x - sheet.positions.data());
        const T across = static_cast<T>(0.1f * static_cast<float>(number % (Sheet<T>::across + 1)));
        const T up = static_cast<T>(0.1f * static_cast<float>(number / (Sheet<T>::across + 1)));
        material.push_back({layer == 0 ? across : -across - T(0.005), up});
        cloth_of_vertex.push_back(0);
      }
    }
    for (const Tri& t : sheet.triangles)
      triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
    if (layer < 2) cloth = static_cast<Index>(positions_t0.size());
  }

  /// Cloth's edges come first, as its faces do.
  void list_edges() {
    std::map<std::pair<Index, Index>, Index> number;
    face_of_vertex.assign(vertex_count(), -1);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto face = static_cast<Index>(t);
      Tri own{};
      for (int k = 0; k < 3; ++k) {
        const Index a = triangles[t].v[(k + 1) % 3], b = triangles[t].v[(k + 2) % 3];
        const Edge edge{{std::min(a, b), std::max(a, b)}};
        const auto [at, fresh] =
            number.try_emplace({edge.v[0], edge.v[1]}, static_cast<Index>(edges.size()));
        own.v[k] = at->second;
        if (fresh) {
          edges.push_back(edge);
          wings.push_back({{triangles[t].v[k], -1}, face});
        } else {
          wings[static_cast<std::size_t>(at->second)].v[1] = triangles[t].v[k];
        }
        Index& first = face_of_vertex[static_cast<std::size_t>(triangles[t].v[k])];
        if (first < 0) first = face;
      }
      edges_of_face.push_back(own);
    }
  }

  void list_rings() {
    std::vector<std::vector<Index>> rings(vertex_count());
    for (const Edge& e : edges)
      for (int j = 0; j < 2; ++j) rings[static_cast<std::size_t>(e.v[j])].push_back(e.v[1 - j]);
    ring_offset.push_back(0);
    for (const std::vector<Index>& own : rings) {
      ring.insert(ring.end(), own.begin(), own.end());
      ring_offset.push_back(static_cast<Offset>(ring.size()));
    }
  }

  struct Extent {
    double lo[3], hi[3];
  };
  Extent extent(const Index* v, int corners) const {
    Extent e{{1e9, 1e9, 1e9}, {-1e9, -1e9, -1e9}};
    for (int j = 0; j < corners; ++j)
      for (const auto* x : {&positions_t0, &positions_t1})
        for (int c = 0; c < 3; ++c) {
          const auto at = static_cast<double>((*x)[static_cast<std::size_t>(v[j])][c]);
          e.lo[c] = std::min(e.lo[c], at - grown);
          e.hi[c] = std::max(e.hi[c], at + grown);
        }
    return e;
  }
  static bool meet(const Extent& a, const Extent& b) {
    for (int c = 0; c < 3; ++c)
      if (a.hi[c] < b.lo[c] || b.hi[c] < a.lo[c]) return false;
    return true;
  }

  void list_pairs() {
    std::vector<Extent> faces, sides;
    for (const Tri& t : triangles) faces.push_back(extent(t.v, 3));
    for (const Edge& e : edges) sides.push_back(extent(e.v, 2));
    for (Index v = 0; v < static_cast<Index>(vertex_count()); ++v) {
      const Extent own = extent(&v, 1);
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Index* f = triangles[t].v;
        if (f[0] == v || f[1] == v || f[2] == v || (v >= cloth && f[0] >= cloth)) continue;
        if (meet(own, faces[t])) face_pairs.push_back({v, static_cast<Index>(t)});
      }
    }
    for (std::size_t p = 0; p < edges.size(); ++p)
      for (std::size_t q = p + 1; q < edges.size(); ++q) {
        const Index *a = edges[p].v, *b = edges[q].v;
        if (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1] || a[0] >= cloth) continue;
        if (meet(sides[p], sides[q]))
          edge_pairs.push_back({static_cast<Index>(p), static_cast<Index>(q)});
      }
  }
};

/// Layers in the memory of a device.
template <class T>
struct LayersOn {
  Buffer<Vec3<T>> positions_t0, positions_t1;
  Buffer<Tri> triangles, edges_of_face;
  Buffer<Edge> edges;
  Buffer<EdgeWings> wings;
  Buffer<Offset> ring_offset;
  Buffer<Index> ring, face_of_vertex, cloth_of_vertex;
  Buffer<Vec2<T>> material;
  Buffer<Pair> face_pairs, edge_pairs;

  LayersOn(Device& device, const Layers<T>& l)
      : positions_t0(upload(device, l.positions_t0)),
        positions_t1(upload(device, l.positions_t1)),
        triangles(upload(device, l.triangles)),
        edges_of_face(upload(device, l.edges_of_face)),
        edges(upload(device, l.edges)),
        wings(upload(device, l.wings)),
        ring_offset(upload(device, l.ring_offset)),
        ring(upload(device, l.ring)),
        face_of_vertex(upload(device, l.face_of_vertex)),
        cloth_of_vertex(upload(device, l.cloth_of_vertex)),
        material(upload(device, l.material)),
        face_pairs(upload(device, l.face_pairs)),
        edge_pairs(upload(device, l.edge_pairs)) {}

  Surface surface() const {
    return {edges.span(),       wings.span(), edges_of_face.span(),
            ring_offset.span(), ring.span(),  face_of_vertex.span()};
  }
};

}  // namespace weft::parity
