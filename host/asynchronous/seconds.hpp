#pragma once

#include <chrono>

namespace weft {

/// [s] of wall time since some fixed point, for differences.
inline double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace weft
