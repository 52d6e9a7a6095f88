#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"

namespace weft {

constexpr Index cluster_size = 8;

/// Eight boxes, coordinate by coordinate, so that a box is compared with all of them at once.
/// Places beyond the last box meet nothing.
template <class T>
struct Cluster {
  alignas(32) T lo[3][cluster_size];
  alignas(32) T hi[3][cluster_size];
};

/// Boxes of one kind of primitive in clusters of eight with consecutive numbers; the boxes around
/// clusters in groups of eight; and the box around each group. Only the boxes of primitives are of
/// the run's precision: the boxes around them are rounded outwards.
template <class T>
struct ClusterList {
  Index first = 0;              ///< number of the first primitive
  Index count = 0;              ///< of primitives
  Span<Cluster<T>> clusters;    ///< [size()]
  Span<Cluster<float>> groups;  ///< [group_count()] the boxes around clusters
  Span<Box> hulls;              ///< [group_count()]
  /// The same for the end of a motion that was split. `clusters` and `groups` then belong to its
  /// start, and `hulls` to the whole motion.
  Span<Cluster<T>> ends;
  Span<Cluster<float>> group_ends;

  WEFT_HD Index size() const noexcept { return (count + cluster_size - 1) / cluster_size; }
  WEFT_HD Index group_count() const noexcept { return (size() + cluster_size - 1) / cluster_size; }
};

/// Kinds of primitives, in the order of CollideBoxes::lists.
enum ClusterKind {
  cloth_vertices,
  obstacle_vertices,
  cloth_faces,
  obstacle_faces,
  cloth_edges,
  obstacle_edges,
  cluster_kinds
};

/// Swept boxes of all vertices, edges and faces over a motion from positions_t0 to positions_t1,
/// and the mean size of the hulls of each kind, from which the grids take their cells. The box of a
/// vertex is the hull of its ends, of its end after `motions_ahead` more motions like this one, so
/// that its pairs last for some steps, and of where its velocity alone takes it in `inertial_time`:
/// what holds cloth against gravity leaves it there. It is grown by a margin: `margin`, or
/// `margin_at_rest` if the whole motion is small enough for that to last for another step; and the
/// change of its velocity in the last step times `change_time`, but no more than `change_max`.
/// Obstacle vertices that stand still have none: nothing but a prescribed motion carries them off.
/// Any later motion that keeps every vertex in its box keeps every primitive in its own. Edges and
/// faces are the hulls of their corners. All are then grown by `reach` once more, so that two
/// primitives closer than 2 reach meet. In double the boxes are exact where nothing is grown; in
/// float they allow for positions that were rounded to float.
///
/// If neighbouring primitives move together by more than their own size, their boxes all overlap,
/// although almost none of the pairs can meet. A motion whose largest displacement along an axis
/// exceeds `split_motion` is therefore split: primitives have one box at its start and one at its
/// end, compared by may_meet(). A vertex' swept AABB then is that of its end alone: a vertex that
/// starts where it did in the search and ends in its swept AABB moves within both boxes of all its
/// primitives, and along a straight line does so by shares in between. That holds for the step from
/// these very positions_t0 only; in a later step, which starts elsewhere, pairs have to be searched
/// again, see CollideOutOfBounds.
///
/// Boxes of obstacles that an earlier search made stand as long as none of their vertices' boxes
/// changes, nor a vertex moves in a motion that is split. Reads: positions, swept AABBs. Writes:
/// boxes. Order: independent; the mean sums in fixed order. Ghosts: all vertices. Flags: split,
/// obstacles_made, obstacles_moved. Every rank makes all boxes, or its part of lists that it
/// shares.
template <class T>
struct CollideBoxes {
  Span<const Vec3<T>> positions_t0;  ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;  ///< [vertices] [m]
  /// [cloth vertices] [m/s]; not read if change_time and inertial_time are 0
  Span<const Vec3<T>> velocities;
  Span<const Vec3<T>> previous_velocities;  ///< [cloth vertices] [m/s] a step ago; as above
  Span<const Edge> edges;
  Span<const Tri> triangles;
  Index cloth_vertex_count = 0;
  T margin;                                             ///< [m]
  T margin_at_rest;                                     ///< [m]
  T change_time;                                        ///< [s]
  T change_max = std::numeric_limits<T>::infinity();    ///< [m]
  T inertial_time = T(0);                               ///< [s]
  T motions_ahead = T(0);                               ///< not of a motion that is split
  T reach;                                              ///< [m]
  T split_motion = std::numeric_limits<T>::infinity();  ///< [m]
  bool make_obstacles = true;                           ///< even if they have not moved
  Span<BoxOf<T>> swept_aabb;                            ///< [vertices] without reach
  ClusterList<T> lists[cluster_kinds];
  Span<float> mean_extent;             ///< [cluster_kinds] [m] of the hulls
  Span<unsigned char> split;           ///< [1] 1: the motion was split
  Span<unsigned char> obstacles_made;  ///< [1] 0: those of an earlier search stand
  /// [1] 1: some moved in a motion that was split, so that none stands in the next search. Read
  /// unless `make_obstacles`.
  Span<unsigned char> obstacles_moved;
  /// On the host, part `part` of `parts` of the groups of each list, if ranks share the lists. The
  /// means then have to wait for all parts.
  int part = 0;
  int parts = 1;
};

/// Grows `box` outwards by `by` and by more than rounding can have taken off: in float, that of the
/// positions included.
template <class T>
WEFT_HD BoxOf<T> grown(BoxOf<T> box, T by) noexcept {
  using std::fabs;
  constexpr bool single = std::is_same_v<T, float>;
  constexpr T relative = single ? T(2.4e-7) : T(4.5e-16);
  constexpr T least = single ? T(1e-37) : T(1e-307);
  if (!single && !(by > T(0))) return box;
  for (int c = 0; c < 3; ++c) {
    box.lo[c] -= by + relative * fabs(box.lo[c]) + least;
    box.hi[c] += by + relative * fabs(box.hi[c]) + least;
  }
  return box;
}

/// Box that meets nothing and adds nothing to a hull.
template <class T>
WEFT_HD constexpr BoxOf<T> empty_box() noexcept {
  constexpr T infinity = std::numeric_limits<T>::infinity();
  return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
}

/// Smallest box around both.
template <class T>
WEFT_HD BoxOf<T> hull(const BoxOf<T>& a, const BoxOf<T>& b) noexcept {
  BoxOf<T> r;
  for (int c = 0; c < 3; ++c) {
    r.lo[c] = a.lo[c] < b.lo[c] ? a.lo[c] : b.lo[c];
    r.hi[c] = a.hi[c] > b.hi[c] ? a.hi[c] : b.hi[c];
  }
  return r;
}

/// To float, outwards.
WEFT_HD inline Box around(const Box& box) noexcept {
  return box;
}
WEFT_HD inline Box around(const BoxOf<double>& box) noexcept {
  Box r;
  for (int c = 0; c < 3; ++c) {
    r.lo[c] = static_cast<float>(box.lo[c]);
    r.hi[c] = static_cast<float>(box.hi[c]);
  }
  return grown(r, 0.0f);
}

/// Mean size of a box along the axes. [m]
WEFT_HD inline float extent(const Box& box) noexcept {
  return (box.hi[0] - box.lo[0] + box.hi[1] - box.lo[1] + box.hi[2] - box.lo[2]) / 3;
}

/// Mean size of the hulls of a list. [m]
inline float mean_extent(Span<const Box> hulls) noexcept {
  double sum = 0;
  for (const Box& hull : hulls) sum += static_cast<double>(extent(hull));
  return hulls.empty() ? 0.0f : static_cast<float>(sum / static_cast<double>(hulls.size()));
}

/// Whether the boxes are not the same; true where either has a NaN.
template <class T>
WEFT_HD bool differ(const BoxOf<T>& a, const BoxOf<T>& b) noexcept {
  for (int c = 0; c < 3; ++c)
    if (a.lo[c] != b.lo[c] || a.hi[c] != b.hi[c]) return true;
  return false;
}

template <class T>
WEFT_HD void set_lane(Cluster<T>& cluster, Index lane, const BoxOf<T>& box) noexcept {
  for (int c = 0; c < 3; ++c) {
    cluster.lo[c][lane] = box.lo[c];
    cluster.hi[c][lane] = box.hi[c];
  }
}

/// Box number `lane` of a cluster, as it is or to a wider precision.
template <class S, class T>
WEFT_HD BoxOf<S> lane_of(const Cluster<T>& cluster, Index lane) noexcept {
  BoxOf<S> box;
  for (int c = 0; c < 3; ++c) {
    box.lo[c] = static_cast<S>(cluster.lo[c][lane]);
    box.hi[c] = static_cast<S>(cluster.hi[c][lane]);
  }
  return box;
}

/// Largest displacement of vertex v along an axis; a NaN counts as none. [m]
template <class T>
WEFT_HD T largest_motion(const CollideBoxes<T>& a, std::size_t v) noexcept {
  using std::fabs;
  T most = T(0);
  for (int c = 0; c < 3; ++c) {
    const T motion = fabs(a.positions_t1.data()[v][c] - a.positions_t0.data()[v][c]);
    if (most < motion) most = motion;
  }
  return most;
}

/// The margin of a motion whose largest displacement along an axis is `motion`. [m]
template <class T>
WEFT_HD T motion_margin(const CollideBoxes<T>& a, T motion) noexcept {
  return motion < a.margin_at_rest / 2 ? a.margin_at_rest : a.margin;
}

/// Whether vertex v does not move; false for a NaN.
template <class T>
WEFT_HD bool stands_still(const CollideBoxes<T>& a, std::size_t v) noexcept {
  const Vec3<T>& p = a.positions_t0.data()[v];
  const Vec3<T>& q = a.positions_t1.data()[v];
  return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

/// Swept AABB of vertex v.
/// @param margin [m] see motion_margin()
/// @param split  whether the motion is
template <class T>
WEFT_HD BoxOf<T> make_swept_aabb(const CollideBoxes<T>& a, std::size_t v, T margin,
                                 bool split) noexcept {
  Vec3<T> q = a.positions_t1.data()[v];
  const Vec3<T> p = split ? q : a.positions_t0.data()[v];
  const bool cloth = v < static_cast<std::size_t>(a.cloth_vertex_count);
  if (!split) q += a.motions_ahead * (q - p);
  BoxOf<T> box;
  for (int c = 0; c < 3; ++c) {
    box.lo[c] = p[c] < q[c] ? p[c] : q[c];
    box.hi[c] = p[c] < q[c] ? q[c] : p[c];
  }
  if (cloth && a.inertial_time > T(0)) {
    const Vec3<T> inertial = a.positions_t0.data()[v] + a.inertial_time * a.velocities.data()[v];
    for (int c = 0; c < 3; ++c) {
      if (inertial[c] < box.lo[c]) box.lo[c] = inertial[c];
      if (box.hi[c] < inertial[c]) box.hi[c] = inertial[c];
    }
  }
  T room = margin;
  if (!cloth && stands_still(a, v)) room = T(0);
  if (cloth && a.change_time > T(0)) {
    const T change =
        a.change_time * length(a.velocities.data()[v] - a.previous_velocities.data()[v]);
    room += change < a.change_max ? change : a.change_max;
  }
  return grown(box, room);
}

/// Box of a primitive, with reach, around box_of(v) of its corners.
/// @param kind a ClusterKind
/// @param i    number of the primitive, cloth first, then obstacle
template <class T, class BoxOfVertex>
WEFT_HD BoxOf<T> box_around_corners(const CollideBoxes<T>& a, int kind, Index i,
                                    BoxOfVertex box_of) noexcept {
  if (kind < cloth_faces) return grown(box_of(i), a.reach);
  if (kind >= cloth_edges) {
    const Edge e = a.edges.data()[i];
    return grown(hull(box_of(e.v[0]), box_of(e.v[1])), a.reach);
  }
  const Tri t = a.triangles.data()[i];
  return grown(hull(hull(box_of(t.v[0]), box_of(t.v[1])), box_of(t.v[2])), a.reach);
}

/// Box of a primitive from the swept AABBs of its corners: of its end, if the motion is split.
template <class T>
WEFT_HD BoxOf<T> primitive_box(const CollideBoxes<T>& a, int kind, Index i) noexcept {
  const BoxOf<T>* motion = a.swept_aabb.data();
  return box_around_corners(a, kind, i, [motion](Index v) { return motion[v]; });
}

/// Box of a primitive where the motion starts.
template <class T>
WEFT_HD BoxOf<T> start_box(const CollideBoxes<T>& a, int kind, Index i) noexcept {
  const Vec3<T>* positions = a.positions_t0.data();
  return box_around_corners(a, kind, i, [positions](Index v) {
    const Vec3<T>& p = positions[v];
    return grown(BoxOf<T>{{p[0], p[1], p[2]}, {p[0], p[1], p[2]}}, T(0));
  });
}

/// All six comparisons at once: which of them fails is anyone's guess, so that stopping at the
/// first costs more in mispredicted branches than it saves.
template <class T>
WEFT_HD bool boxes_meet(const BoxOf<T>& a, const BoxOf<T>& b) noexcept {
  return (static_cast<int>(a.lo[0] <= b.hi[0]) & static_cast<int>(b.lo[0] <= a.hi[0]) &
          static_cast<int>(a.lo[1] <= b.hi[1]) & static_cast<int>(b.lo[1] <= a.hi[1]) &
          static_cast<int>(a.lo[2] <= b.hi[2]) & static_cast<int>(b.lo[2] <= a.hi[2])) != 0;
}

/// Boxes of something at the start and at the end of its motion.
template <class T>
struct SplitBox {
  BoxOf<T> start;
  BoxOf<T> end;
};

/// Whether two primitives, each moving from one box to another, may meet. They cannot if along some
/// axis one lies below the other both at the start and at the end: on straight lines the bounds of
/// all that moves from a0 to a1 lie inside (1 - t) a0 + t a1, so that the gap at time t is no less
/// than the same mean of the gaps at both ends. False where a box is empty.
template <class T>
WEFT_HD bool may_meet(const SplitBox<T>& a, const SplitBox<T>& b) noexcept {
  int meets = 1;
  for (int c = 0; c < 3; ++c)
    meets &= (static_cast<int>(a.start.lo[c] <= b.start.hi[c]) |
              static_cast<int>(a.end.lo[c] <= b.end.hi[c])) &
             (static_cast<int>(b.start.lo[c] <= a.start.hi[c]) |
              static_cast<int>(b.end.lo[c] <= a.end.hi[c]));
  return meets != 0;
}

template <class T>
void run(OnHost, Queue& queue, const CollideBoxes<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollideBoxes<T>& args);

}  // namespace weft
