#pragma once

#include <functional>
#include <vector>

#include "host/untangle/contour.hpp"

namespace weft {

struct UntangleSettings {
  double gap;            ///< [m] wanted between surfaces that were intersecting, > 0
  int rounds_max = 600;  ///< of motion, per mesh and attempt
  /// Called in each round; what it throws ends the untangling. Empty: nothing.
  std::function<void()> each_round{};
};

/// How untangling went.
struct UntangleReport {
  /// [m] at the start, after each round, and after motion on a coarser mesh
  std::vector<double> contour_length;
  /// What could not be resolved, where it was least; empty: all is well.
  Contours left;
};

/// Moves cloth out of itself and of obstacles. Round by round, find_corrections() says what has to
/// go back, the surroundings come along (Spreader), and contours are found again. Where they no
/// longer get shorter, regions are carried along their normals, forth and then back, and cloth
/// around contours is smoothed. Large meshes follow a coarser mesh of the same cloth first
/// (CoarseSurfaces), which follows a coarser one, and so on: a round goes a quarter of an edge. The
/// rounds are bounded, by three times `rounds_max` per mesh. Points far from any contour do not
/// move. The result depends on the input alone, to the bit.
/// @param surfaces points are moved; those with inverse mass 0 stay
UntangleReport untangle(IntersectingSurfaces& surfaces, const UntangleSettings& settings);

}  // namespace weft
