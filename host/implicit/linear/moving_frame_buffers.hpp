#pragma once

#include <cstdint>

#include "host/implicit/linear/rank_rows.hpp"

namespace weft {

/// Components of a rank's cloth as rigid bodies, see IntegrateMovingFrame.
template <class T>
struct MovingFrameBuffers {
  Buffer<Vec3<T>> positions, velocities;  ///< [cloth vertices] [m], [m/s] turned_*
  Buffer<std::int32_t> turned;            ///< [1] whether any component turns
  Buffer<Index> meets;                    ///< [components]

  void make(Device& device, Index vertices, std::size_t components) {
    weft::make(device, positions, static_cast<std::size_t>(vertices));
    weft::make(device, velocities, static_cast<std::size_t>(vertices));
    weft::make(device, turned, 1);
    weft::make(device, meets, components);
  }
};

}  // namespace weft
