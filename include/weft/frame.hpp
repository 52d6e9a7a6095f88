#pragma once

#include <cstddef>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// The state at one time, for use outside the engine: positions and velocities in input order. The
/// scene's meshes hold the topology.
struct Frame {
  int number = 0;
  double time = 0;                                          ///< [s]
  std::vector<std::vector<Vec3<double>>> cloth_positions;   ///< [cloth][vertex] [m]
  std::vector<std::vector<Vec3<double>>> cloth_velocities;  ///< [m/s]
  /// [obstacle][vertex] [m] where the scene puts obstacles at `time`, rounded to run precision
  std::vector<std::vector<Vec3<double>>> obstacle_positions;
  /// [obstacle][vertex] [m] where the step left obstacles that cloth displaced; empty for an
  /// obstacle in its prescribed place, or within rounding of it
  std::vector<std::vector<Vec3<double>>> displaced_obstacle_positions;
  Vec3<double> origin{0, 0, 0};  ///< [m] add it to the positions to get world positions

  /// Whether cloth has displaced any obstacle.
  bool any_displaced() const;

  /// [vertex] [m] where the simulation has obstacle `o`: cloth keeps clear of this shape.
  const std::vector<Vec3<double>>& simulated_obstacle(std::size_t o) const;
};

inline bool Frame::any_displaced() const {
  for (const auto& positions : displaced_obstacle_positions)
    if (!positions.empty()) return true;
  return false;
}

inline const std::vector<Vec3<double>>& Frame::simulated_obstacle(std::size_t o) const {
  return o < displaced_obstacle_positions.size() && !displaced_obstacle_positions[o].empty()
             ? displaced_obstacle_positions[o]
             : obstacle_positions[o];
}

}  // namespace weft
