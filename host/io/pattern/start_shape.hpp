#pragma once

#include "host/io/pattern/garment.hpp"

namespace weft::io {

/// Sews a garment where its panels stand: vertices that a seam makes one go to their mean, and the
/// cloth around them follows until no edge is much longer than at rest. Cloth that comes near the
/// body on the way is kept outside of it, as far as single vertices can tell. Panels stand far from
/// each other, so that the first step of a simulation would else begin with edges ten times as long
/// as at rest. A bounded number of sweeps over all edges, in their order.
/// @param garment positions change
/// @param body    [m] y up, closed, front outside; may be empty
void relax_start(Garment& garment, const Mesh& body);

/// Largest length of an edge over its length at rest.
double largest_stretch(const Garment& garment);

}  // namespace weft::io
