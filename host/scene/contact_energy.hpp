#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Energy that contacts can release: enough to lift all cloth by the thickness, and to throw it
/// that far within a step, because their stiffness follows from the step.
/// @param step [s]
/// @return [J]
double energy_of_contacts(const Scene& scene, double step);

}  // namespace weft
