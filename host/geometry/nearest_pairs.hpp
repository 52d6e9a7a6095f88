#pragma once

#include <utility>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Points of two sets that are nearest to each other, both ways; of several at one distance the
/// first in its set is the nearest.
/// @param a, b [m] finite
/// @return numbers in a and in b, by ascending number in a; no point in more than one pair
std::vector<std::pair<Index, Index>> nearest_pairs(const std::vector<Vec3<double>>& a,
                                                   const std::vector<Vec3<double>>& b);

}  // namespace weft
