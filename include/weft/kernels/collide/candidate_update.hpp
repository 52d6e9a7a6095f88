#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/out_of_bounds.hpp"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// A vertex of the cloth that has left its motion box.
template <class T>
struct Stray {
  Index vertex;
  BoxOf<T> box;  ///< that it has left
};

/// A primitive with a corner that has strayed.
struct TouchedPrimitive {
  int kind;      ///< cloth_vertices, cloth_faces or cloth_edges
  Index number;  ///< of the primitive
};

/// What CollideStrays finds, which may exceed the capacities.
struct StrayCounts {
  Index strays = 0;
  Index obstacles = 0;  ///< of the strays
  Index touched = 0;
  Index face_pairs = 0;
  Index edge_pairs = 0;
};

/// Pairs that a search lacks because a few vertices have left their motion boxes: grows these
/// boxes, and those of what is around them, and holds what has a corner there against all the rest.
/// The pairs of the search and these are those of a search with the grown boxes. The grids stay as
/// they were, so that nothing asks them before the next search. Reads: positions, boxes. Writes:
/// boxes, stray_of, strays, touched, pairs, counts. Order: none; a pair of two that are touched may
/// stand there twice. Ghosts: all vertices. Flags: counts above capacity, or obstacles above 0: a
/// whole search is called for then. Every rank grows all boxes.
template <class T>
struct CollideStrays {
  CollideBoxes<T> boxes;           ///< of the latest search, but where positions_t1 are now
  bool self = true;                ///< cloth against cloth
  bool search = true;              ///< pairs too; else boxes only
  Span<Index> stray_of;            ///< [vertices] into strays; -1: has not strayed
  Span<Stray<T>> strays;           ///< capacity
  Span<TouchedPrimitive> touched;  ///< capacity
  Span<Pair> face_pairs;           ///< capacity
  Span<Pair> edge_pairs;           ///< capacity
  Span<StrayCounts> counts;        ///< [1]
};

/// Whether vertex v ends outside its motion box.
template <class T>
WEFT_HD bool has_strayed(const CollideStrays<T>& a, Index v) noexcept {
  return !keeps_to(a.boxes.motion_box.data()[v], a.boxes.positions_t1.data()[v]);
}

/// Whether there is room for all strays, and none of them is an obstacle's.
template <class T>
WEFT_HD bool may_grow(const CollideStrays<T>& a) noexcept {
  const StrayCounts& counts = a.counts.data()[0];
  return static_cast<std::size_t>(counts.strays) <= a.strays.size() && counts.obstacles == 0;
}

/// Grows the box of stray n, and keeps the one before.
template <class T>
WEFT_HD void grow_stray(const CollideStrays<T>& a, Index n) noexcept {
  Stray<T>& stray = a.strays.data()[n];
  const auto v = static_cast<std::size_t>(stray.vertex);
  BoxOf<T>& box = a.boxes.motion_box.data()[v];
  stray.box = box;
  box = hull(box, make_motion_box(a.boxes, v, a.boxes.margin, a.boxes.split.data()[0] != 0));
}

/// Whether a corner of primitive i has strayed.
/// @param kind of the cloth
template <class T>
WEFT_HD bool is_touched(const CollideStrays<T>& a, int kind, Index i) noexcept {
  const Index* stray_of = a.stray_of.data();
  if (kind == cloth_vertices) return stray_of[i] >= 0;
  if (kind == cloth_edges) {
    const Edge e = a.boxes.edges.data()[i];
    return stray_of[e.v[0]] >= 0 || stray_of[e.v[1]] >= 0;
  }
  const Tri t = a.boxes.triangles.data()[i];
  return stray_of[t.v[0]] >= 0 || stray_of[t.v[1]] >= 0 || stray_of[t.v[2]] >= 0;
}

/// Boxes of a primitive as they are now, and as they were before its corners strayed.
template <class T>
struct GrownBoxes {
  SplitBox<T> now, before;
};

template <class T>
WEFT_HD GrownBoxes<T> grown_boxes(const CollideStrays<T>& a, int kind, Index i) noexcept {
  const BoxOf<T> now = primitive_box(a.boxes, kind, i);
  const BoxOf<T> before = box_around_corners(a.boxes, kind, i, [&a](Index v) {
    const Index n = a.stray_of.data()[v];
    return n < 0 ? a.boxes.motion_box.data()[v] : a.strays.data()[n].box;
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

/// Calls found(pair) for what a touched primitive meets in a group, but did not meet before: pairs
/// as CollidePairs lists them.
/// @param x     boxes of the touched primitive
/// @param kind  of the group
/// @param found void(const Pair&)
template <class T, class Found>
WEFT_HD void meet_group(const CollideStrays<T>& a, const TouchedPrimitive& touched,
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
      if (touched.kind == cloth_vertices) {
        if (shares_no_vertex(touched.number, triangles[other])) found(Pair{touched.number, other});
      } else if (touched.kind == cloth_faces) {
        if (shares_no_vertex(other, triangles[touched.number])) found(Pair{other, touched.number});
      } else if (other != touched.number && shares_no_vertex(edges[touched.number], edges[other])) {
        found(touched.number < other ? Pair{touched.number, other} : Pair{other, touched.number});
      }
    }
  }
}

template <class T>
void run(OnHost, Queue& queue, const CollideStrays<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollideStrays<T>& args);

}  // namespace weft
