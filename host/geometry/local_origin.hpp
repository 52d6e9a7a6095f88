#pragma once

#include <vector>

#include "weft/core/vec.hpp"

namespace weft {

/// A point that surfaces may be described from, so that distance from (0, 0, 0) costs no precision.
///
/// On each axis it is the roundest number near the middle of the surfaces: the one that the largest
/// power of two divides. Near is within half a size, or within four sizes if that power is at least
/// sixteen times the distance. The size is the longest side of the bounding box. Zero is the
/// roundest of all, so surfaces within four sizes of it keep the origin of the world. Surfaces
/// moved by a multiple of a power of two of at least 64 sizes get the origin that they had, moved
/// by that offset; so do those about zero if it is at least 16 times the distance of their middle
/// from zero. Coordinates minus the origin are exact, because both are multiples of the last place
/// of the coordinate.
/// @param positions [m] of each surface
/// @return          [m] (0, 0, 0) unless there are points, all of them finite
Vec3<double> local_origin(const std::vector<const std::vector<Vec3<double>>*>& positions);

/// Describes points from `to` instead of `from`, both in world positions. Does not touch the bits
/// if the two are the same.
void move_origin(std::vector<Vec3<double>>& positions, const Vec3<double>& from,
                 const Vec3<double>& to);

}  // namespace weft
