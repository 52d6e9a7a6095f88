#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// What became of one vertex of a zone.
template <class T>
struct MovedVertex {
  Index vertex;
  Vec3<T> position;  ///< [m] at the end of the step
};

}  // namespace weft
