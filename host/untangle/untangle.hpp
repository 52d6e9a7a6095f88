#pragma once

#include <functional>
#include <vector>

#include "host/untangle/contour.hpp"

namespace weft {

struct UntangleSettings {
  double gap;            ///< [m] wanted between surfaces that were intersecting, > 0
  int rounds_max = 600;  ///< of motion
  /// Called in each round; what it throws ends the untangling. Empty: nothing.
  std::function<void()> each_round{};
};

/// How untangling went.
struct UntangleReport {
  std::vector<double> contour_length;  ///< [m] at the start and after each round
  /// What could not be resolved, where it was least; empty: all is well.
  Contours left;
};

/// Moves cloth out of itself and of obstacles. Round by round, find_corrections() says what has to
/// go back, the surroundings come along (Spreader), and contours are found again. Where they no
/// longer get shorter, regions are carried along their normals, forth and then back, and cloth
/// around contours is smoothed; the rounds are bounded in any case. Points far from any contour do
/// not move. The result depends on the input alone, to the bit.
/// @param surfaces points are moved; those with inverse mass 0 stay
UntangleReport untangle(IntersectingSurfaces& surfaces, const UntangleSettings& settings);

}  // namespace weft
