#pragma once

#include "weft/core/vec.hpp"

namespace weft {

/// The path of a vertex through a window as a straight line, and how far it deviates from it.
struct Chord {
  Vec3<double> from;     ///< [m] where the window begins
  Vec3<double> to;       ///< [m] where it ends
  double deviation = 0;  ///< [m] largest distance from the line at the same time
};

}  // namespace weft
