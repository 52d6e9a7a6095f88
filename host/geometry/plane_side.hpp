#pragma once

#include "weft/core/vec.hpp"

namespace weft {

/// Sign of det[a - d, b - d, c - d], exact but for underflow: 0 if and only if the four points lie
/// in a plane. A bound on the rounding decides all but the close cases, which are summed without
/// rounding errors.
/// @param a,b,c,d [m] finite
/// @return -1, 0 or 1
int plane_side(const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& c,
               const Vec3<double>& d);

}  // namespace weft
