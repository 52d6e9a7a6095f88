#pragma once

#include <optional>

#include "weft/scene.hpp"

namespace weft::lab {

/// Where the trunk of a body is narrowest.
struct Waist {
  double height = 0;       ///< [m] along `up`
  double body_height = 0;  ///< [m] see BodyFigure::height()
};

/// Measures plane sections across `up` through the trunk, from the crotch to three quarters of the
/// way to the shoulders, 1 cm apart on a body of 1.7 m.
/// @param body standing, closed there
/// @param up   unit
/// @return nothing for a body without limbs
std::optional<Waist> find_waist(const Mesh& body, const Vec3<double>& up);

}  // namespace weft::lab
