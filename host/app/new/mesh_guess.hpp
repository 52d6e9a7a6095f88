#pragma once

#include <optional>
#include <string>

#include "host/geometry/aabb.hpp"

namespace weft::app {

/// A value of a scene, and why it was chosen.
struct Guess {
  std::string value;
  std::string reason;  ///< one line, for a comment
};

/// Value of "units". Cloth and bodies of people are 0.1 to 10 m large. Files of both come from one
/// program, so the body, whose size is better known, tells the unit of the cloth too.
/// @param cloth,body in the coordinates of their files; so the next
Guess guess_units(const Aabb& cloth, const std::optional<Aabb>& body);

/// Value of "up". A body that stands says it; else cloth that starts above a body; else cloth that
/// lies flat; else what programs usually write in this format.
/// @param extension of the cloth's file, with its dot
Guess guess_up(const Aabb& cloth, const std::optional<Aabb>& body, const std::string& extension);

}  // namespace weft::app
