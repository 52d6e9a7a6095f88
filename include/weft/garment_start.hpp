#pragma once

#include <string>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// How the seams of a garment are closed.
enum class SewnStart {
  automatic,  ///< welded, and by springs if that start cannot be parted
  welded,     ///< at time 0
  springs,    ///< by the springs of seams; gravity sets in once all seams of the scene are closed
};

/// A cloth that is sewn from panels. Its mesh has these where they are sewn.
struct GarmentStart {
  Index cloth = 0;  ///< into Scene::cloths
  /// In the scene of a simulation: what was done, never `automatic`.
  SewnStart start = SewnStart::automatic;
  /// [vertices] [m] where the panels stand before they are sewn. Empty in the scene of a
  /// simulation, with `welded`, and with `springs` if the mesh has them there.
  std::vector<Vec3<double>> apart{};
  /// In the scene of a simulation: why a welded start was given up; empty: it was not.
  std::string reason{};
};

}  // namespace weft
