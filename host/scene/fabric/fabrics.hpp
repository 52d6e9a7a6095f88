#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// A fabric that scenes may call by its name.
struct Fabric {
  const char* name;
  const char* description;  ///< what it is made of and for
  const char* source;       ///< of its numbers; of an estimate, the reasoning
  Material material;        ///< without a name
  /// No public measurement has density, stretching and bending of one piece.
  bool estimate = false;
};

/// Fabric of cloth that names none: measured, woven, neither light nor heavy.
inline constexpr const char* default_fabric = "cotton_polyester";

/// All of them, in the order of their names.
const std::vector<Fabric>& fabrics();

/// @return nullptr if there is none of that name
const Fabric* find_fabric(const std::string& name);

}  // namespace weft
