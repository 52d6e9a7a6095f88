#pragma once

#include <optional>

#include "weft/scene.hpp"

namespace weft::lab {

/// Where the trunk of a body is narrowest.
struct Waist {
  double height = 0;       ///< [m] along `up`
  double body_height = 0;  ///< [m] see BodyFigure::height()
};

/// Measures 41 plane sections across `up` through the trunk, from 0.3 to 0.75 of the way from the
/// crotch to the shoulders.
/// @param body standing, closed there
/// @param up   unit
/// @return nothing for a body without limbs
std::optional<Waist> find_waist(const Mesh& body, const Vec3<double>& up);

}  // namespace weft::lab
