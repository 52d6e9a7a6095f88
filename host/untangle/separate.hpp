#pragma once

#include <vector>

#include "host/untangle/contour.hpp"
#include "host/untangle/spread.hpp"

namespace weft {

/// Moves apart what is closer than `gap`, so that repulsion finds little to do; neighbours on one
/// cloth, as far as they are apart at rest and it is not compressed. Looked at are vertices and
/// triangles, and pairs of edges, that no edge joins and of which one has an awake point.
/// Continuous detection guards every motion: what does not intersect before, does not after. Rounds
/// are bounded; where there is no room, or pins hold, less than the gap has to do. No pair ends
/// nearer than a quarter of what it had, or than a fortieth of the gap.
/// @param awake [points] those that move are added
/// @param gap   [m] > 0
/// @pre  nothing intersects or touches
void separate(IntersectingSurfaces& surfaces, const SurfaceTopology& topology,
              ContourSearch& search, Spreader& spreader, std::vector<unsigned char>& awake,
              double gap);

}  // namespace weft
