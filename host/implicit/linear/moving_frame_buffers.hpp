#pragma once

#include "host/implicit/linear/rank_rows.hpp"

namespace weft {

/// Components of a rank's cloth as rigid bodies, see IntegrateMovingFrame.
template <class T>
struct MovingFrameBuffers {
  Buffer<Vec3<T>> positions, velocities;  ///< [cloth vertices] [m], [m/s] turned_*
  Buffer<Vec3<T>> relative_velocities;    ///< [cloth vertices] [m/s]
  Buffer<Index> meets;                    ///< [components]

  void make(Device& device, Index vertices, std::size_t components) {
    weft::make(device, positions, static_cast<std::size_t>(vertices));
    weft::make(device, velocities, static_cast<std::size_t>(vertices));
    weft::make(device, relative_velocities, static_cast<std::size_t>(vertices));
    weft::make(device, meets, components);
  }
};

}  // namespace weft
