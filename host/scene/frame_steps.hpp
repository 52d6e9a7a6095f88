#pragma once

#include <algorithm>
#include <cmath>

#include "weft/scene.hpp"

namespace weft {

/// Steps that one frame takes: the scene's time step, shortened so that frames are hit exactly.
inline int frame_steps(const TimeSettings& time) {
  // A frame that takes a hair more than a whole number of steps takes that number.
  const double steps = 1 / (time.frame_rate * time.step);
  return std::max(1, static_cast<int>(std::ceil(steps * (1 - 1e-9))));
}

/// [s] length of such a step
inline double frame_step_length(const TimeSettings& time) {
  return 1 / (time.frame_rate * frame_steps(time));
}

}  // namespace weft
