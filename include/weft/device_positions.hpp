#pragma once

#include <cstddef>

#include "weft/core/vec.hpp"

namespace weft {

/// Positions of a cloth where the simulation runs, see Simulation::device_positions().
struct DevicePositions {
  const Vec3<float>* data = nullptr;  ///< [size] [m] in the memory of that GPU, or of the host
  std::size_t size = 0;               ///< vertices
  int gpu = -1;                       ///< as CUDA numbers them; -1: the host
};

}  // namespace weft
