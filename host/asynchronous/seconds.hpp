#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace weft {

/// [s] of wall time since some fixed point, for differences.
inline double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Such as "3e-05 s".
inline std::string seconds_text(double time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g s", time);
  return text;
}

}  // namespace weft
