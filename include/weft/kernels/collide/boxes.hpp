#pragma once

#include <cmath>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Swept boxes of all vertices, edges and faces over a motion from positions_t0 to positions_t1,
/// and the mean size of each kind, from which the grids take their cells. The box of a vertex is
/// the hull of its ends, grown by a margin: `margin` and the change of its velocity in the last
/// step times `change_time`. Any later motion that keeps every vertex in its box keeps every
/// primitive in its own. Edges and faces are the hulls of their corners. All are then grown by
/// `reach` once more, so that two primitives closer than 2 reach meet. Reads: positions. Writes:
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
  Index cloth_edge_count = 0;
  Index cloth_triangle_count = 0;
  T margin;                 ///< [m]
  T change_time;            ///< [s]
  T reach;                  ///< [m]
  Span<Box> motion_box;     ///< [vertices] without reach
  Span<Box> vertex_box;     ///< [vertices]
  Span<Box> edge_box;       ///< [edges]
  Span<Box> triangle_box;   ///< [triangles]
  Span<float> mean_extent;  ///< [4] cloth faces, obstacle faces, cloth edges, obstacle edges
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
