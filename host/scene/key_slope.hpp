#pragma once

#include <algorithm>
#include <cmath>

namespace weft {

/// Slope at a key, brought into the region where a cubic Hermite curve never leaves the interval
/// between two neighbouring keys (Fritsch & Carlson 1980: at most three times the slope of either
/// chord, zero where the chords differ in sign).
/// @param before, after slopes of the chords on both sides
/// @param slope         of the chord across both
inline double limited_slope(double before, double after, double slope) {
  if (!(before * after > 0)) return 0;
  const double most = 3 * std::min(std::fabs(before), std::fabs(after));
  return std::clamp(slope, -most, most);
}

}  // namespace weft
