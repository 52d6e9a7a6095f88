#pragma once

#include <vector>

#include "weft/core/vec.hpp"

namespace weft {

/// x -> rotate(scale * x) + translate
struct Similarity {
  double rotation[4] = {0, 0, 0, 1};  ///< unit quaternion x, y, z, w
  double scale = 1;
  Vec3<double> translate{0, 0, 0};

  Vec3<double> operator()(const Vec3<double>& x) const;
};

/// The similarity that takes points nearest to others, in the sense of least squares (Horn 1987,
/// "Closed-form solution of absolute orientation using unit quaternions").
/// @pre both have the same number of points
Similarity fitted_similarity(const std::vector<Vec3<double>>& from,
                             const std::vector<Vec3<double>>& to);

}  // namespace weft
