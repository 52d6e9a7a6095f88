#include "host/model/surface_tables.hpp"

#include <algorithm>
#include <cstddef>

#include "host/base/buckets.hpp"
#include "host/base/parallel.hpp"

namespace weft {
namespace {

/// @param first [vertices + 1] the first edge whose lower vertex is this, or comes after it
Index edge_number(const Model& model, const std::vector<Index>& first, Index a, Index b) {
  const Index hi = std::max(a, b);
  Index e = first[static_cast<std::size_t>(std::min(a, b))];
  while (model.edges[static_cast<std::size_t>(e)].v[1] != hi) ++e;
  return e;
}

void find_edges(const Model& model, SurfaceTables& tables) {
  // Edges are sorted, so that this leaves their order.
  const std::vector<Index> first =
      buckets_by(static_cast<Index>(model.edges.size()), model.vertex_count, [&](Index e) {
        return model.edges[static_cast<std::size_t>(e)].v[0];
      }).offset;
  tables.edges_of_face.resize(model.triangles.size());
  for_each_index(setup_threads(model.triangles.size()), model.triangles.size(), [&](std::size_t t) {
    const Index* v = model.triangles[t].v;
    for (int k = 0; k < 3; ++k)
      tables.edges_of_face[t].v[k] = edge_number(model, first, v[(k + 1) % 3], v[(k + 2) % 3]);
  });
}

void add_face(const Model& model, Index t, SurfaceTables& tables) {
  const Tri& face = model.triangles[static_cast<std::size_t>(t)];
  const Tri& edges = tables.edges_of_face[static_cast<std::size_t>(t)];
  for (int k = 0; k < 3; ++k) {
    EdgeWings& wings = tables.wings[static_cast<std::size_t>(edges.v[k])];
    if (wings.first_face < 0) wings.first_face = t;
    if (wings.v[0] < 0)
      wings.v[0] = face.v[k];
    else if (wings.v[1] < 0)
      wings.v[1] = face.v[k];
    Index& any = tables.face_of_vertex[static_cast<std::size_t>(face.v[k])];
    if (any < 0) any = t;
  }
}

void find_wings(const Model& model, SurfaceTables& tables) {
  tables.wings.assign(model.edges.size(), {{-1, -1}, -1});
  tables.face_of_vertex.assign(static_cast<std::size_t>(model.vertex_count), -1);
  for (std::size_t t = 0; t < model.triangles.size(); ++t)
    add_face(model, static_cast<Index>(t), tables);
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
  find_edges(model, tables);
  for_each_index(std::min(2U, setup_threads(model.triangles.size())), 2, [&](std::size_t part) {
    part == 0 ? find_wings(model, tables) : make_rings(model, tables);
  });
  return tables;
}

}  // namespace weft
