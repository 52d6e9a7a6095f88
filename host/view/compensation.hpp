#pragma once

#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Share of a compression that a triangle's material sees, ((b - A) / (b - a))^k with a and b the
/// least and the greatest area of all that are out of the frustum; 1 where these are equal, and of
/// all that are not.
/// @param areas [triangles] [m^2] in material space   @param out [triangles] out of the frustum
/// @return      [triangles]; empty where all are 1
/// @cite koh2015, eq. (11) and (12)
std::vector<double> compression_shares(const std::vector<double>& areas,
                                       const std::vector<unsigned char>& out,
                                       const ViewSettings& settings);

}  // namespace weft
