#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Checks the method, the settings of all methods, and what the scene's own method cannot do.
/// @throws SceneError
void validate_methods(const Scene& scene);

}  // namespace weft
