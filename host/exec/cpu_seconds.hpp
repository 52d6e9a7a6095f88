#pragma once

#include <ctime>

namespace weft {

/// [s] of processors that all threads of this process have used.
inline double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

}  // namespace weft
