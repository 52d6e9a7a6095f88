#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// What became of one vertex of a zone.
template <class T>
struct MovedVertex {
  Index vertex;
  Vec3<T> position;  ///< [m] at the end of the step
};

struct ZoneCounts {
  Index zones = 0;
  Index moved = 0;
  Index largest = 0;   ///< collisions of the largest zone
  Index unsolved = 0;  ///< zones whose constraints could not all be met
  Index yielding = 0;  ///< prescribed vertices among those that moved
};

/// Inelastic impact zones (P-Cloth section 4.3; Harmon et al. 2008): for each connected set of
/// collisions, the smallest change of the end positions, weighted by mass, that restores every
/// collision's offset along its normal. The quadratic programme is solved on its dual: sweeps over
/// the multipliers, each set to what its own constraint asks, which is an augmented Lagrangian
/// method with exact inner steps. Vertices of obstacles and fixed ones have infinite mass.
/// With `rigid`, a zone moves as one body instead: it keeps its linear and angular momentum, or
/// follows the prescribed motion that touches it (Provot 1997; Bridson et al. 2002).
/// A zone that cannot be solved because what is prescribed squeezes it - an arm that is pressed
/// into the ribs, with cloth in between - makes that yield: its prescribed vertices then have a
/// mass too, several times that of cloth, and end the step as near to their places as the cloth
/// lets them. Runs on one rank. Only zones with a collision from `first_new` on are solved. Reads:
/// collisions, positions. Writes: moved, counts, yielding. Order: collisions as given. Flags:
/// unsolved, yielding.
template <class T>
struct RespondZones {
  Span<const Collision> collisions;  ///< of all rounds of this step
  Index first_new = 0;
  Span<const Vec3<T>> positions_t0;    ///< [vertices] [m] start of the step
  Span<const Vec3<T>> positions_free;  ///< [vertices] [m] end of the step before any response
  Span<const T> mass;                  ///< [cloth vertices] [kg]
  Span<const unsigned char> fixed;     ///< [cloth vertices]
  Index cloth_vertex_count = 0;
  bool rigid = false;
  Span<unsigned char> yielding;  ///< [vertices] 1: prescribed, but has yielded in this step
  Span<MovedVertex<T>> moved;    ///< [4 collisions]
  Span<ZoneCounts> counts;       ///< [1]
};

template <class T>
void run(OnHost, Queue& queue, const RespondZones<T>& args);

}  // namespace weft
