#pragma once

#include <cmath>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"

namespace weft {

constexpr Index cluster_size = 8;

/// Boxes of eight primitives with consecutive numbers, coordinate by coordinate, so that a box is
/// compared with all of them at once. Places beyond the last primitive meet nothing.
struct Cluster {
  alignas(32) float lo[3][cluster_size];
  alignas(32) float hi[3][cluster_size];
};

/// The clusters of one kind of primitive, and the box around each.
struct ClusterList {
  Index first = 0;         ///< number of the first primitive
  Index count = 0;         ///< of primitives
  Span<Cluster> clusters;  ///< [ceil(count / cluster_size)]
  Span<Box> hulls;         ///< same

  Index size() const noexcept { return (count + cluster_size - 1) / cluster_size; }
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
/// vertex is the hull of its ends, grown by a margin: `margin` and the change of its velocity in
/// the last step times `change_time`. Any later motion that keeps every vertex in its box keeps
/// every primitive in its own. Edges and faces are the hulls of their corners. All are then grown
/// by `reach` once more, so that two primitives closer than 2 reach meet. Reads: positions. Writes:
/// boxes. Order: independent; the mean sums in fixed order. Ghosts: all vertices. Flags: none.
/// Every rank makes all boxes.
template <class T>
struct CollideBoxes {
  Span<const Vec3<T>> positions_t0;         ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;         ///< [vertices] [m]
  Span<const Vec3<T>> velocities;           ///< [cloth vertices] [m/s]
  Span<const Vec3<T>> previous_velocities;  ///< [cloth vertices] [m/s] a step ago
  Span<const Edge> edges;
  Span<const Tri> triangles;
  Index cloth_vertex_count = 0;
  T margin;              ///< [m]
  T change_time;         ///< [s]
  T reach;               ///< [m]
  Span<Box> motion_box;  ///< [vertices] without reach
  ClusterList lists[cluster_kinds];
  Span<float> mean_extent;  ///< [cluster_kinds] [m] of the hulls
};

/// Grows `box` outwards by `by` and by more than float rounding can have taken off.
WEFT_HD inline Box grown(Box box, float by) noexcept {
  using std::fabs;
  for (int c = 0; c < 3; ++c) {
    box.lo[c] -= by + 2.4e-7f * fabs(box.lo[c]) + 1e-37f;
    box.hi[c] += by + 2.4e-7f * fabs(box.hi[c]) + 1e-37f;
  }
  return box;
}

/// Smallest box around both.
WEFT_HD inline Box hull(const Box& a, const Box& b) noexcept {
  using std::fmax;
  using std::fmin;
  Box r;
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
