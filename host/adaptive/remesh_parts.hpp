#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

/// What a remesh is given and what it tells, for those who need not know how it goes about it.
namespace weft {

/// What new triangles must not run into.
struct Surroundings {
  std::vector<Vec3<double>> positions;  ///< [m] of obstacles
  std::vector<Tri> triangles;           ///< of obstacles
  bool self = true;                     ///< whether cloth must not meet cloth
  double gap = 0;                       ///< [m] that triangles without a common vertex must keep
};

/// What a remesh did.
struct RemeshCounts {
  std::int64_t splits = 0;
  std::int64_t flips = 0;
  std::int64_t collapses = 0;
  std::int64_t refused = 0;  ///< that would have met something, or cost too much energy
};

template <class T>
struct MaterialRows;

/// What a remesh may add to the elastic energy or take from it.
struct EnergyBudget {
  /// [J] all flips and collapses together, one split alone; infinity: any
  double joules;
  const MaterialRows<double>* laws = nullptr;  ///< of all materials; null only where any will do
  double splits = std::numeric_limits<double>::infinity();  ///< [J] all splits together, at most
};

}  // namespace weft
