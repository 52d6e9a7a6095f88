#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// The state at one instant as others see it: positions of all cloths and obstacles, in the order
/// of the scene and of its meshes. Topology stands in the scene's meshes.
struct Frame {
  int number = 0;
  double time = 0;                                            ///< [s]
  std::vector<std::vector<Vec3<double>>> cloth_positions;     ///< [m] a cloth, a vertex
  std::vector<std::vector<Vec3<double>>> cloth_velocities;    ///< [m/s]
  std::vector<std::vector<Vec3<double>>> obstacle_positions;  ///< [m]
};

}  // namespace weft
