#pragma once

#include <cstddef>
#include <optional>

#include "host/scene/surfaces.hpp"
#include "weft/scene.hpp"

namespace weft {

/// A move of a whole cloth.
struct Lift {
  Vec3<double> direction;  ///< unit vector
  double distance;         ///< [m]
};

/// How far a cloth has to be lifted against gravity, or along z without any, until it neither meets
/// an obstacle nor lies inside one, and a contact thickness further if there is room. Rounded to
/// three digits.
/// @param surfaces of the scene, which has obstacles
/// @return nothing if no lift clears the cloth
std::optional<Lift> lift_clear(const Scene& scene, const Surfaces& surfaces, std::size_t cloth);

}  // namespace weft
