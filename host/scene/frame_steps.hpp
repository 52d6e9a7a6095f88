#pragma once

#include <algorithm>
#include <cmath>

#include "weft/scene.hpp"

namespace weft {

/// Steps of automatic length that one frame may take. None is shorter than a frame over this.
inline constexpr int automatic_frame_steps_max = 10'000;

/// [s] The scene's time step; of automatic steps the longest there may be, a frame.
inline double longest_step(const TimeSettings& time) {
  return time.automatic ? 1 / time.frame_rate : time.step;
}

/// [s] when a frame is due
inline double frame_time(const TimeSettings& time, int frame) {
  return frame / time.frame_rate;
}

/// Steps that one frame takes: the scene's time step, shortened so that frames are hit exactly.
/// @pre steps are not automatic
inline int frame_steps(const TimeSettings& time) {
  // A frame that takes a hair more than a whole number of steps takes that number.
  const double steps = 1 / (time.frame_rate * time.step);
  return std::max(1, static_cast<int>(std::ceil(steps * (1 - 1e-9))));
}

/// [s] length of such a step
inline double frame_step_length(const TimeSettings& time) {
  return 1 / (time.frame_rate * frame_steps(time));
}

/// Steps that one frame may take.
inline int most_frame_steps(const TimeSettings& time) {
  return time.automatic ? automatic_frame_steps_max : frame_steps(time);
}

}  // namespace weft
