#pragma once

#include "host/io/pattern/garment.hpp"

namespace weft::io {

/// Moves the panels of skirts and trousers down where they stand above an arm: a wide skirt is as
/// wide as the arms of its body reach, and sewing front to back would take the arms in. A panel is
/// one of these if it is labelled "leg" or all of it stands below the armpits, and if some of it
/// stands before or behind the trunk. It is compressed, not folded, and only beside the trunk.
/// @param garment as its panels stand; positions change
/// @param body    [m] y up; nothing happens without arms that reach out, farther than the hips
void clear_arms(Garment& garment, const Mesh& body);

}  // namespace weft::io
