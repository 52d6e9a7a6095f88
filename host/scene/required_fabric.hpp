#pragma once

#include <string>

#include "host/scene/fabric/fabrics.hpp"

namespace weft {

/// @param field for the message
/// @throws SceneError if there is no fabric of that name
const Fabric& required_fabric(const std::string& name, const std::string& field);

}  // namespace weft
