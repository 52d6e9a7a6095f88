#pragma once

#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Numbers of `points` along a Morton curve; equal codes keep their order.
/// @pre points is not empty and finite
std::vector<Index> morton_order(const std::vector<Vec3<double>>& points);

}  // namespace weft
