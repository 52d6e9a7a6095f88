#pragma once

#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Areas of the smallest and of the largest triangles that a cloth's meshes should have. [m^2]
struct AreaRange {
  double least, greatest;
};

/// Share of a compression that a triangle's material sees, ((b - A) / (b - a))^k with a and b the
/// least and the greatest area, within 0 and 1; 1 where a triangle is in the frustum.
///
/// The paper takes a and b from the triangles that are out of the frustum. One that comes or goes
/// then changes the shares of all others, and adds elastic energy to what is compressed: here they
/// are what the cloth's sizes allow.
/// @param areas  [triangles] [m^2] in material space
/// @param ranges [triangles]
/// @param out    [triangles] out of the frustum
/// @return       [triangles]; empty where all are 1
/// @cite koh2015, eq. (11) and (12)
std::vector<double> compression_shares(const std::vector<double>& areas,
                                       const std::vector<AreaRange>& ranges,
                                       const std::vector<unsigned char>& out,
                                       const ViewSettings& settings);

}  // namespace weft
