#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

/// Inputs and results of a remesh, for code that does not need the algorithm itself.
namespace weft {

/// Obstacles that new triangles must not touch, and the rules for cloth.
struct Surroundings {
  std::vector<Vec3<double>> positions;  ///< [m] of obstacles
  std::vector<Tri> triangles;           ///< of obstacles
  bool self = true;                     ///< whether cloth must not touch cloth
  double gap = 0;                       ///< [m] between triangles without a common vertex
};

/// Counts of the operations of a remesh.
struct RemeshCounts {
  std::int64_t splits = 0;
  std::int64_t flips = 0;
  std::int64_t collapses = 0;
  std::int64_t refused = 0;  ///< would have caused an intersection or cost too much energy
};

template <class T>
struct MaterialRows;

/// Limits of the change of elastic energy by a remesh.
struct EnergyBudget {
  /// [J] for all flips and collapses together, and for each single split; infinity: no limit
  double joules;
  const MaterialRows<double>* laws = nullptr;  ///< of all materials; null only without a limit
  double splits = std::numeric_limits<double>::infinity();  ///< [J] for all splits together
};

}  // namespace weft
