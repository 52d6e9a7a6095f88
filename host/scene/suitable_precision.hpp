#pragma once

#include "weft/scene.hpp"

namespace weft {

/// The precision of a run whose scene names none: double if, for some material,
///   r = h^2 (k + B / A) (1 + d / h) / (density A)
/// is above 1e7, with the step h, stretching k, bending B, damping d and the mean area A of a
/// triangle. This is the stiffness of a step over the mass. In single precision, rounding in
/// products with the stiffness hides the inertia of a motion as a whole if r is much larger, and
/// linear solves do not converge.
/// @return double as well for the method "asynchronous", which knows no other
Precision suitable_precision(const Scene& scene);

}  // namespace weft
