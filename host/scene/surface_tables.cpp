#include "host/scene/surface_tables.hpp"

#include <algorithm>
#include <cstddef>

namespace weft {
namespace {

Index edge_number(const Model& model, Index a, Index b) {
  const Index lo = std::min(a, b);
  const Index hi = std::max(a, b);
  const auto found = std::lower_bound(model.edges.begin(), model.edges.end(), Edge{{lo, hi}},
                                      [](const Edge& p, const Edge& q) {
                                        return p.v[0] != q.v[0] ? p.v[0] < q.v[0] : p.v[1] < q.v[1];
                                      });
  return static_cast<Index>(found - model.edges.begin());
}

void add_face(const Model& model, Index t, SurfaceTables& tables) {
  const Tri& face = model.triangles[static_cast<std::size_t>(t)];
  Tri& edges = tables.edges_of_face[static_cast<std::size_t>(t)];
  for (int k = 0; k < 3; ++k) {
    edges.v[k] = edge_number(model, face.v[(k + 1) % 3], face.v[(k + 2) % 3]);
    EdgeWings& wings = tables.wings[static_cast<std::size_t>(edges.v[k])];
    if (wings.first_face < 0) wings.first_face = t;
    if (wings.v[0] < 0)
      wings.v[0] = face.v[k];
    else if (wings.v[1] < 0)
      wings.v[1] = face.v[k];
    Index& first = tables.face_of_vertex[static_cast<std::size_t>(face.v[k])];
    if (first < 0) first = t;
  }
}

void make_rings(const Model& model, SurfaceTables& tables) {
  tables.ring_offset.assign(static_cast<std::size_t>(model.vertex_count) + 1, 0);
  for (const Edge& e : model.edges)
    for (const Index v : e.v) ++tables.ring_offset[static_cast<std::size_t>(v) + 1];
  for (std::size_t v = 1; v < tables.ring_offset.size(); ++v)
    tables.ring_offset[v] += tables.ring_offset[v - 1];
  tables.ring.resize(2 * model.edges.size());
  std::vector<Offset> next(tables.ring_offset.begin(), tables.ring_offset.end() - 1);
  for (const int end : {1, 0})  // lower neighbours of a vertex come before the higher ones
    for (const Edge& e : model.edges)
      tables.ring[static_cast<std::size_t>(next[static_cast<std::size_t>(e.v[end])]++)] =
          e.v[1 - end];
}

}  // namespace

SurfaceTables make_surface_tables(const Model& model) {
  SurfaceTables tables;
  tables.wings.assign(model.edges.size(), {{-1, -1}, -1});
  tables.edges_of_face.resize(model.triangles.size());
  tables.face_of_vertex.assign(static_cast<std::size_t>(model.vertex_count), -1);
  for (std::size_t t = 0; t < model.triangles.size(); ++t)
    add_face(model, static_cast<Index>(t), tables);
  make_rings(model, tables);
  return tables;
}

}  // namespace weft
