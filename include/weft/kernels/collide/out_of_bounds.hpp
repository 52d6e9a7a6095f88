#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Whether a vertex is inside its swept AABB; false for a NaN.
template <class T>
WEFT_HD bool keeps_to(const BoxOf<T>& box, const Vec3<T>& x) noexcept {
  for (int c = 0; c < 3; ++c)
    if (!(x[c] >= box.lo[c] && x[c] <= box.hi[c])) return false;
  return true;
}

/// Counts the vertices of this rank's share that start or end outside their swept AABB; all, if the
/// motion of the search was split, whose pairs serve no other step. If there are none on any rank,
/// the pairs of the search that made the boxes are all that can meet. Reads: positions, motion
/// boxes, split. Writes: counts.out_of_bounds. Order: independent. Ghosts: none.
template <class T>
struct CollideOutOfBounds {
  Span<const Vec3<T>> positions_t0;  ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;  ///< [vertices] [m]
  Span<const BoxOf<T>> swept_aabb;   ///< [vertices]
  Index vertex_begin = 0, vertex_end = 0;
  Span<CollideCounts> counts;       ///< [1]
  Span<const unsigned char> split;  ///< [1] see CollideBoxes; empty: 0
};

/// Whether vertex v starts and ends in its swept AABB, which holds all of its motion.
template <class T>
WEFT_HD bool keeps_to_its_box(const CollideOutOfBounds<T>& a, Index v) noexcept {
  if (!a.split.empty() && a.split.data()[0] != 0) return false;
  const BoxOf<T> box = a.swept_aabb.data()[v];
  return keeps_to(box, a.positions_t0.data()[v]) && keeps_to(box, a.positions_t1.data()[v]);
}

template <class T>
void run(OnHost, Queue& queue, const CollideOutOfBounds<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollideOutOfBounds<T>& args);

}  // namespace weft
