#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"

namespace weft::io {

/// Panels that stand where sewing cannot take them around the body: within it, or far from what
/// they are sewn to, as a sleeve beside the other arm.
/// @param garment where its panels stand
/// @param body    [m] y up; may be empty
/// @return at most a line for either fault, for messages
std::vector<std::string> misplaced_panels(const Garment& garment, const Mesh& body);

}  // namespace weft::io
