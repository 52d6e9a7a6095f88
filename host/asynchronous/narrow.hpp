#pragma once

#include <cstdint>

#include "host/asynchronous/layers.hpp"
#include "host/asynchronous/trajectory.hpp"

namespace weft {

/// What the narrow phase did.
struct NarrowCounts {
  std::int64_t calls = 0;     ///< pairs
  std::int64_t slabs = 0;     ///< that were tried
  std::int64_t failsafe = 0;  ///< pairs that went on to continuous detection
  std::int64_t ccd = 0;       ///< its calls, one a piece of the pair's ways

  NarrowCounts& operator+=(const NarrowCounts& b) {
    calls += b.calls;
    slabs += b.slabs;
    failsafe += b.failsafe;
    ccd += b.ccd;
    return *this;
  }
};

/// Spans of time shorter than this go to continuous detection. [s]
/// @cite ainsley2012
inline constexpr double slab_span_min = 1e-10;
/// So many slabs for one pair, and the rest of its time goes to continuous detection: a bound for
/// pairs that dance at the brink.
inline constexpr int slabs_max = 2000;

/// Whether a pair may come within `distance` while its corners move as recorded. Never wrongly
/// false: every span of time is passed over only on a proof, rounding counted. Wrongly true for
/// distances above by up to a thousandth.
///   Algorithm 3: where the pair is closest halfway, a slab across that direction, which moves at
///   the pair's own mean speed, keeps the two apart until the first corner leaves its side; what is
///   left of the time on both ends is treated the same way.
/// @param ways     [4] of the corners, all over the same span of time
/// @param slabs    false: continuous detection alone, piece by piece
/// @param rounding [m] by which projections of positions may be off
/// @cite ainsley2012, algorithm 3; departs from it in slabs that move and in their bound
bool comes_within(const PrimitivePair& pair, const Trajectory trajectories[4], double distance,
                  bool slabs, double rounding, NarrowCounts& counts);

}  // namespace weft
