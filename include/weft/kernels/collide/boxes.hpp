#pragma once

#include <cmath>
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
/// the run's precision: what stands around them is rounded outwards.
template <class T>
struct ClusterList {
  Index first = 0;              ///< number of the first primitive
  Index count = 0;              ///< of primitives
  Span<Cluster<T>> clusters;    ///< [size()]
  Span<Cluster<float>> groups;  ///< [group_count()] the boxes around clusters
  Span<Box> hulls;              ///< [group_count()]

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
/// vertex is the hull of its ends, grown by a margin: `margin`, or `margin_at_rest` if the whole
/// motion is small enough for that to last for another step; and the change of its velocity in the
/// last step times `change_time`. Obstacle vertices that stand still have none: nothing but a
/// prescribed motion carries them off. Any later motion that keeps every vertex in its box keeps
/// every primitive in its own. Edges and faces are the hulls of their corners. All are then grown
/// by `reach` once more, so that two primitives closer than 2 reach meet. In double the boxes are
/// exact where nothing is grown; in float they allow for positions that were rounded to float.
/// Boxes of obstacles that an earlier search made stand as long as none of their vertices' boxes
/// changes. Reads: positions, motion boxes. Writes: boxes. Order: independent; the mean sums in
/// fixed order. Ghosts: all vertices. Flags: obstacles_made. Every rank makes all boxes.
template <class T>
struct CollideBoxes {
  Span<const Vec3<T>> positions_t0;         ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;         ///< [vertices] [m]
  Span<const Vec3<T>> velocities;           ///< [cloth vertices] [m/s]; not read if change_time = 0
  Span<const Vec3<T>> previous_velocities;  ///< [cloth vertices] [m/s] a step ago; likewise
  Span<const Edge> edges;
  Span<const Tri> triangles;
  Index cloth_vertex_count = 0;
  T margin;                   ///< [m]
  T margin_at_rest;           ///< [m]
  T change_time;              ///< [s]
  T reach;                    ///< [m]
  bool anew = true;           ///< obstacles in any case
  Span<BoxOf<T>> motion_box;  ///< [vertices] without reach
  ClusterList<T> lists[cluster_kinds];
  Span<float> mean_extent;             ///< [cluster_kinds] [m] of the hulls
  Span<unsigned char> obstacles_made;  ///< [1] 0: those of an earlier search stand
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

/// All six comparisons at once: which of them fails is anyone's guess, so that stopping at the
/// first costs more in mispredicted branches than it saves.
WEFT_HD inline bool boxes_meet(const Box& a, const Box& b) noexcept {
  return (static_cast<int>(a.lo[0] <= b.hi[0]) & static_cast<int>(b.lo[0] <= a.hi[0]) &
          static_cast<int>(a.lo[1] <= b.hi[1]) & static_cast<int>(b.lo[1] <= a.hi[1]) &
          static_cast<int>(a.lo[2] <= b.hi[2]) & static_cast<int>(b.lo[2] <= a.hi[2])) != 0;
}

template <class T>
void run(OnHost, Queue& queue, const CollideBoxes<T>& args);

}  // namespace weft
