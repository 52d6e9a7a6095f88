#pragma once

#include <vector>

#include "weft/core/vec.hpp"

namespace weft {

/// A point that surfaces may be described from, so that distance from (0, 0, 0) costs no precision.
///
/// On each axis it is the roundest number within four sizes of the middle of the surfaces: the one
/// that the largest power of two divides. The size is the longest side of their bounding box. Zero
/// is the roundest of all, so ordinary scenes keep the origin of the world. Surfaces moved by an
/// offset that is rounder than eight sizes get the origin that they had, moved by that offset.
/// Coordinates minus the origin are exact, because both are multiples of the last place of the
/// coordinate.
/// @param positions [m] of each surface
/// @return          [m] (0, 0, 0) unless there are points, all of them finite
Vec3<double> local_origin(const std::vector<const std::vector<Vec3<double>>*>& positions);

/// Describes points from `to` instead of `from`, both in world positions. Does not touch the bits
/// if the two are the same.
void move_origin(std::vector<Vec3<double>>& positions, const Vec3<double>& from,
                 const Vec3<double>& to);

}  // namespace weft
