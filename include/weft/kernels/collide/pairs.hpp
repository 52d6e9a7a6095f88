#pragma once

#include <cstdint>

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
  Index face_collisions = 0;  ///< as above
  Index missed = 0;           ///< collisions of pairs that were no contacts
  Index out_of_bounds = 0;    ///< vertices outside their swept AABB
  Index not_finite = 0;
  Offset tests = 0;      ///< box tests of the broad phase
  Offset ccd_tests = 0;  ///< pairs that the cheap test could not decide
  float slide = 0;       ///< largest ProximityRule::slide() of the contacts
};

/// A workload table as a whole, in the unit of which shares of it are parts.
constexpr std::uint32_t whole_table = 1u << 30;

/// What one rank asks of the queries that a workload table counts. The shares of all ranks, in
/// their order, make up the whole.
struct WorkShare {
  std::uint32_t begin = 0;
  std::uint32_t end = whole_table;
};

/// Broad phase: pairs of primitives that share no vertex and whose boxes meet, or, where the motion
/// was split, may_meet() on the way from those of its start to those of its end. Vertex against
/// face: cloth against cloth and obstacle, obstacle against cloth. Edge against edge: cloth against
/// cloth and obstacle. Each rank asks for its share of the vertices and edges, a group of clusters
/// at a time; which these are changes no result. Reads: boxes, grids over the hulls of
/// groups, workload tables. Writes: face_pairs, edge_pairs, counts. Order: by asking primitive,
/// then by face or edge, so that the ranks' lists joined are the same for any number of ranks.
/// Flags: counts above capacity; nothing is then to be read from the lists, and the caller launches
/// again. Counts, box tests included, are those of the host; more pairs than an Index can number
/// are a DeviceError of the queue there, and the largest Index in CUDA, which no caller has memory
/// for.
template <class T>
struct CollidePairs {
  Span<const Edge> edges;
  Span<const Tri> triangles;
  ClusterList<T> lists[cluster_kinds];
  Grid grids[cluster_kinds];        ///< of faces and edges
  bool self = true;                 ///< cloth against cloth
  Span<const unsigned char> split;  ///< [1] see CollideBoxes; empty: 0
  Span<const Offset> face_work;  ///< [groups of vertices, cloth then obstacle, + 1] see CollideWork
  Span<const Offset> edge_work;  ///< [groups of the cloth's edges + 1]
  WorkShare face_share;          ///< of this rank
  WorkShare edge_share;
  Span<Pair> face_pairs;       ///< capacity
  Span<Pair> edge_pairs;       ///< capacity
  Span<CollideCounts> counts;  ///< [1]
};

/// First group of a share: where the sum of work reaches that part of the whole.
/// @param work  a table of CollideWork
/// @param begin up to whole_table, where a share begins behind the last group
WEFT_HD inline Index share_begin(Span<const Offset> work, std::uint32_t begin) noexcept {
  const auto groups = static_cast<Index>(work.size()) - 1;
  const Offset whole = work.data()[groups];
  const Offset part = whole / whole_table * begin + whole % whole_table * begin / whole_table;
  Index low = 0;
  Index high = groups;
  while (low < high) {
    const Index middle = low + (high - low) / 2;
    if (work.data()[middle] < part)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/// Whether a vertex is none of a face's corners.
WEFT_HD inline bool shares_no_vertex(Index v, const Tri& t) noexcept {
  return (static_cast<int>(t.v[0] != v) & static_cast<int>(t.v[1] != v) &
          static_cast<int>(t.v[2] != v)) != 0;
}

/// Whether two edges have no end in common.
WEFT_HD inline bool shares_no_vertex(const Edge& p, const Edge& q) noexcept {
  return (static_cast<int>(p.v[0] != q.v[0]) & static_cast<int>(p.v[0] != q.v[1]) &
          static_cast<int>(p.v[1] != q.v[0]) & static_cast<int>(p.v[1] != q.v[1])) != 0;
}

template <class T>
void run(OnHost, Queue& queue, const CollidePairs<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollidePairs<T>& args);

}  // namespace weft
