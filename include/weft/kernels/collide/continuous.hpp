#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Continuous detection over the step, in double whatever the precision of the run: a pair collides
/// if its distance falls below `separation` (or half of its distance at the start, if that is
/// less). Also checks that every vertex kept to its motion box, without which the pairs are not
/// all. First round: all pairs. Later rounds: pairs of which a vertex has moved since. Reads:
/// pairs, positions. Writes: collisions, counts. Order: as the pairs. Ghosts: all vertices. Flags:
/// escaped, not_finite, counts above capacity. Where a vertex has escaped, and with
/// `stop_at_missed` where a collision of no contact is found, the rest may be left out: only that
/// it is so counts.
template <class T>
struct CollideContinuous {
  Span<const Pair> face_pairs;  ///< capacity; the number stands in counts
  Span<const Pair> edge_pairs;
  Span<const float> face_slack;  ///< [capacity] [m] as CollideProximity left it
  Span<const float> edge_slack;
  Span<const Edge> edges;
  Span<const Tri> triangles;
  Span<const Vec3<T>> positions_t0;  ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;  ///< [vertices] [m]
  Span<const Vec3<T>> predicted;     ///< [vertices] [m] the positions_t1 that the slack is of
  Span<float> deviation;             ///< [vertices] scratch [m] from the prediction
  Span<const BoxOf<T>> motion_box;   ///< [vertices]
  Span<const unsigned char> moved;   ///< [vertices] since the last round; empty: first round
  /// This rank's share of cloth and obstacle (which may yield), checked against their motion boxes.
  Index vertex_begin = 0, vertex_end = 0;
  double separation;           ///< [m] under which a pair collides
  double offset;               ///< [m] gap that the response restores
  Span<Collision> collisions;  ///< capacity
  Span<CollideCounts> counts;  ///< [1]
  bool stop_at_missed = false;
};

template <class T>
void run(OnHost, Queue& queue, const CollideContinuous<T>& args);

}  // namespace weft
