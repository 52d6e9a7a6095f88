#pragma once

#include "weft/core/vec.hpp"

namespace weft {

/// The way of a vertex through a window as a straight line, and how far it goes astray from that.
struct Chord {
  Vec3<double> from;     ///< [m] where the window begins
  Vec3<double> to;       ///< [m] where it ends
  double deviation = 0;  ///< [m] most that the way is from the line, at one time
};

}  // namespace weft
