#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/out_of_bounds.hpp"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// A vertex of the cloth that has left its swept AABB.
template <class T>
struct OutOfBoundsVertex {
  Index vertex;
  BoxOf<T> box;  ///< that it has left
};

/// A primitive with a corner that is out of bounds.
struct DirtyPrimitive {
  int kind;      ///< cloth_vertices, cloth_faces or cloth_edges
  Index number;  ///< of the primitive
};

/// What CollideCandidateUpdate finds, which may exceed the capacities.
struct CandidateUpdateCounts {
  Index out_of_bounds = 0;
  Index obstacles = 0;  ///< of the out_of_bounds
  Index dirty = 0;
  Index face_pairs = 0;
  Index edge_pairs = 0;
};

/// Pairs that a search lacks because a few vertices have left their swept AABBs: grows these
/// boxes, and those of what is around them, and holds what has a corner there against all the rest.
/// The pairs of the search and these are those of a search with the grown boxes. The grids stay as
/// they were, so that nothing asks them before the next search. Reads: positions, boxes. Writes:
/// boxes, out_of_bounds_index, out_of_bounds, dirty, pairs, counts. Order: none; a pair of two that
/// are dirty may stand there twice. Ghosts: all vertices. Flags: counts above capacity, or
/// obstacles above 0: a whole search is called for then. Every rank grows all boxes, but of lists
/// that ranks share only the one of part 0 does.
template <class T>
struct CollideCandidateUpdate {
  CollideBoxes<T> boxes;            ///< of the latest search, but where positions_t1 are now
  bool self = true;                 ///< cloth against cloth
  bool search = true;               ///< pairs too; else boxes only
  Span<Index> out_of_bounds_index;  ///< [vertices] into out_of_bounds; -1: is within bounds
  Span<OutOfBoundsVertex<T>> out_of_bounds;  ///< capacity
  Span<DirtyPrimitive> dirty;                ///< capacity
  Span<Pair> face_pairs;                     ///< capacity
  Span<Pair> edge_pairs;                     ///< capacity
  Span<CandidateUpdateCounts> counts;        ///< [1]
};

/// Whether vertex v ends outside its swept AABB.
template <class T>
WEFT_HD bool is_out_of_bounds(const CollideCandidateUpdate<T>& a, Index v) noexcept {
  return !keeps_to(a.boxes.swept_aabb.data()[v], a.boxes.positions_t1.data()[v]);
}

/// Whether there is room for all out_of_bounds, and none of them is an obstacle's.
template <class T>
WEFT_HD bool may_grow(const CollideCandidateUpdate<T>& a) noexcept {
  const CandidateUpdateCounts& counts = a.counts.data()[0];
  return static_cast<std::size_t>(counts.out_of_bounds) <= a.out_of_bounds.size() &&
         counts.obstacles == 0;
}

/// Grows the box of out-of-bounds vertex n, and saves its previous box.
template <class T>
WEFT_HD void grow_swept_aabb(const CollideCandidateUpdate<T>& a, Index n) noexcept {
  OutOfBoundsVertex<T>& vertex = a.out_of_bounds.data()[n];
  const auto v = static_cast<std::size_t>(vertex.vertex);
  BoxOf<T>& box = a.boxes.swept_aabb.data()[v];
  vertex.box = box;
  box = hull(box, make_swept_aabb(a.boxes, v, a.boxes.margin, a.boxes.split.data()[0] != 0));
}

/// Whether a corner of primitive i is out of bounds.
/// @param kind of the cloth
template <class T>
WEFT_HD bool is_dirty(const CollideCandidateUpdate<T>& a, int kind, Index i) noexcept {
  const Index* out_of_bounds_index = a.out_of_bounds_index.data();
  if (kind == cloth_vertices) return out_of_bounds_index[i] >= 0;
  if (kind == cloth_edges) {
    const Edge e = a.boxes.edges.data()[i];
    return out_of_bounds_index[e.v[0]] >= 0 || out_of_bounds_index[e.v[1]] >= 0;
  }
  const Tri t = a.boxes.triangles.data()[i];
  return out_of_bounds_index[t.v[0]] >= 0 || out_of_bounds_index[t.v[1]] >= 0 ||
         out_of_bounds_index[t.v[2]] >= 0;
}

/// Boxes of a primitive as they are now, and as they were before its corners strayed.
template <class T>
struct GrownBoxes {
  SplitBox<T> now, before;
};

template <class T>
WEFT_HD GrownBoxes<T> grown_boxes(const CollideCandidateUpdate<T>& a, int kind, Index i) noexcept {
  const BoxOf<T> now = primitive_box(a.boxes, kind, i);
  const BoxOf<T> before = box_around_corners(a.boxes, kind, i, [&a](Index v) {
    const Index n = a.out_of_bounds_index.data()[v];
    return n < 0 ? a.boxes.swept_aabb.data()[v] : a.out_of_bounds.data()[n].box;
  });
  if (a.boxes.split.data()[0] == 0) return {{now, now}, {before, before}};
  const BoxOf<T> start = start_box(a.boxes, kind, i);
  return {{start, now}, {start, before}};
}

/// Kinds of primitives that one of `kind` makes pairs with are `first` and, of obstacles, the next.
WEFT_HD inline int partner_kind(int kind) noexcept {
  return kind == cloth_vertices ? cloth_faces : kind == cloth_faces ? cloth_vertices : cloth_edges;
}

/// Box number i of a list.
template <class S>
WEFT_HD SplitBox<S> box_of_list(Span<Cluster<S>> starts, Span<Cluster<S>> ends, Index i,
                                bool split) noexcept {
  const Index cluster = i / cluster_size, lane = i % cluster_size;
  const BoxOf<S> start = lane_of<S>(starts.data()[cluster], lane);
  return {start, split ? lane_of<S>(ends.data()[cluster], lane) : start};
}

/// Calls found(pair) for what a dirty primitive meets in a group, but did not meet before: pairs
/// as CollidePairs lists them.
/// @param x     boxes of the dirty primitive
/// @param kind  of the group
/// @param found void(const Pair&)
template <class T, class Found>
WEFT_HD void meet_group(const CollideCandidateUpdate<T>& a, const DirtyPrimitive& dirty,
                        const GrownBoxes<T>& x, int kind, Index group, const Found& found) {
  const bool split = a.boxes.split.data()[0] != 0;
  const ClusterList<T>& list = a.boxes.lists[kind];
  const SplitBox<float> outer{around(x.now.start), around(x.now.end)};
  if (!boxes_meet(hull(outer.start, outer.end), list.hulls.data()[group])) return;
  for (Index k = group * cluster_size; k < (group + 1) * cluster_size && k < list.size(); ++k) {
    if (!may_meet(outer, box_of_list<float>(list.groups, list.group_ends, k, split))) continue;
    for (Index i = k * cluster_size; i < (k + 1) * cluster_size && i < list.count; ++i) {
      if (!may_meet(x.now, box_of_list<T>(list.clusters, list.ends, i, split))) continue;
      const Index other = list.first + i;
      if (may_meet(x.before, grown_boxes(a, kind, other).before)) continue;
      const Edge* edges = a.boxes.edges.data();
      const Tri* triangles = a.boxes.triangles.data();
      if (dirty.kind == cloth_vertices) {
        if (shares_no_vertex(dirty.number, triangles[other])) found(Pair{dirty.number, other});
      } else if (dirty.kind == cloth_faces) {
        if (shares_no_vertex(other, triangles[dirty.number])) found(Pair{other, dirty.number});
      } else if (other != dirty.number && shares_no_vertex(edges[dirty.number], edges[other])) {
        found(dirty.number < other ? Pair{dirty.number, other} : Pair{other, dirty.number});
      }
    }
  }
}

template <class T>
void run(OnHost, Queue& queue, const CollideCandidateUpdate<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollideCandidateUpdate<T>& args);

}  // namespace weft
