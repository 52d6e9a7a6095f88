#pragma once

#include "host/asynchronous/chord.hpp"
#include "host/asynchronous/layers.hpp"

namespace weft {

/// A distance that a pair stays above, or at, all through the window: across the direction in which
/// its lines are closest halfway, its gap there is a concave function of time, so that it is
/// smallest where the window begins or ends, less the largest deviation of paths from their lines.
/// Often less than the pair's smallest distance; below zero it says nothing. [m]
/// @param corners [4]
double least_gap(const PrimitivePair& pair, const Chord* const corners[4]);

/// A bound on how much farther a point of one primitive goes through the window than one of the
/// other, in any direction. [m]
/// @param corners [4]
double most_approach(const PrimitivePair& pair, const Chord* const corners[4]);

}  // namespace weft
