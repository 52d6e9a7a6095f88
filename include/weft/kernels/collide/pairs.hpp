#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/grid.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Numbers that the host reads after the collision kernels: how many were found (which may exceed
/// the capacity: then the caller grows the arrays and launches again), and the work it took.
struct CollideCounts {
  Index face_pairs = 0;
  Index edge_pairs = 0;
  Index contacts = 0;
  Index face_contacts = 0;  ///< of the contacts, those of face pairs; they stand first
  Index collisions = 0;
  Index face_collisions = 0;  ///< likewise
  Index missed = 0;           ///< collisions of pairs that were no contacts
  Index escaped = 0;          ///< vertices outside their motion box
  Index not_finite = 0;
  Offset tests = 0;      ///< box tests of the broad phase
  Offset ccd_tests = 0;  ///< pairs that the cheap test could not decide
};

/// Broad phase: pairs of primitives that share no vertex and whose boxes meet. Vertex against face:
/// cloth against cloth and obstacle, obstacle against cloth. Edge against edge: cloth against cloth
/// and obstacle. Each rank asks for its share of the vertices and edges, a group of clusters at a
/// time; the shares are equal by the workload tables.
/// Reads: boxes, grids over the hulls of groups, workload tables. Writes: face_pairs, edge_pairs,
/// counts. Order: by asking primitive, then by face or edge, so that the ranks' lists joined are
/// the same for any number of ranks. Flags: counts above capacity.
template <class T>
struct CollidePairs {
  Span<const Edge> edges;
  Span<const Tri> triangles;
  ClusterList<T> lists[cluster_kinds];
  Grid grids[cluster_kinds];     ///< of faces and edges
  bool self = true;              ///< cloth against cloth
  Span<const Offset> face_work;  ///< [groups of vertices, cloth then obstacle, + 1] see CollideWork
  Span<const Offset> edge_work;  ///< [groups of the cloth's edges + 1]
  int rank = 0, ranks = 1;
  Span<Pair> face_pairs;       ///< capacity
  Span<Pair> edge_pairs;       ///< capacity
  Span<CollideCounts> counts;  ///< [1]
};

template <class T>
void run(OnHost, Queue& queue, const CollidePairs<T>& args);

}  // namespace weft
