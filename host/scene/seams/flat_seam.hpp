#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Whether a seam pulls cloth together that lies flat between its two sides, at the start and at
/// rest, over at least half of the cloth's extent. Its springs act within the plane of such cloth,
/// so they crush it where they should roll it. The sides of a dart have no cloth between them.
/// @pre the vertices of the seam exist
bool crushes_flat_cloth(const Cloth& cloth, const Seam& seam);

}  // namespace weft
