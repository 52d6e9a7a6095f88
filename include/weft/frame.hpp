#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// The state at one time, for use outside the engine: positions and velocities in input order. The
/// scene's meshes hold the topology.
struct Frame {
  int number = 0;
  double time = 0;                                            ///< [s]
  std::vector<std::vector<Vec3<double>>> cloth_positions;     ///< [cloth][vertex] [m]
  std::vector<std::vector<Vec3<double>>> cloth_velocities;    ///< [m/s]
  std::vector<std::vector<Vec3<double>>> obstacle_positions;  ///< [m]
};

}  // namespace weft
