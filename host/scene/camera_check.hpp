#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Refuses a camera that is inside a closed obstacle at any frame of the run.
/// @pre validate(scene) passes, and the camera has keys
/// @throws SceneError with obstacle and time
void refuse_camera_inside(const Scene& scene);

}  // namespace weft
