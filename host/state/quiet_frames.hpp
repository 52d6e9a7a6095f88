#pragma once

#include <cstdint>
#include <vector>

#include "weft/core/vec.hpp"

namespace weft {

/// Quiet frames in a row, see RestState.
struct QuietFrames {
  std::int32_t count = 0;
  std::vector<Vec3<double>> since;  ///< [vertices of cloth] [m] where it was before the first
};

}  // namespace weft
