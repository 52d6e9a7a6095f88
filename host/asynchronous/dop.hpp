#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "weft/core/vec.hpp"

namespace weft {

/// Number of axes of a 26-DOP: 3 along coordinates, 4 along the diagonals of a cube, 6 along those
/// of its faces.
inline constexpr int dop_axes = 13;

/// Coordinates of a point along the axes, which are not of unit length.
inline void dop_project(const Vec3<double>& x, double (&out)[dop_axes]) {
  out[0] = x[0];
  out[1] = x[1];
  out[2] = x[2];
  const double sum = x[0] + x[1], difference = x[0] - x[1];
  out[3] = sum + x[2];
  out[4] = sum - x[2];
  out[5] = difference + x[2];
  out[6] = difference - x[2];
  out[7] = sum;
  out[8] = difference;
  out[9] = x[0] + x[2];
  out[10] = x[0] - x[2];
  out[11] = x[1] + x[2];
  out[12] = x[1] - x[2];
}

/// Length of an axis.
inline double dop_length(int axis) {
  if (axis < 3) return 1;
  return axis < 7 ? 1.7320508075688774 : 1.4142135623730951;
}

/// Polytope with sides across 13 fixed axes. Empty at first.
struct Dop {
  double lo[dop_axes];
  double hi[dop_axes];

  Dop() {
    for (int k = 0; k < dop_axes; ++k) {
      lo[k] = std::numeric_limits<double>::infinity();
      hi[k] = -lo[k];
    }
  }
  void include(const Vec3<double>& x) {
    double p[dop_axes];
    dop_project(x, p);
    for (int k = 0; k < dop_axes; ++k) {
      lo[k] = std::min(lo[k], p[k]);
      hi[k] = std::max(hi[k], p[k]);
    }
  }
  void include(const Dop& b) {
    for (int k = 0; k < dop_axes; ++k) {
      lo[k] = std::min(lo[k], b.lo[k]);
      hi[k] = std::max(hi[k], b.hi[k]);
    }
  }
  /// Whether a gap along some axis shows that the two are farther apart than `distance`.
  bool farther(const Dop& b, double distance) const {
    for (int k = 0; k < dop_axes; ++k)
      if (std::max(lo[k] - b.hi[k], b.lo[k] - hi[k]) > distance * dop_length(k)) return true;
    return false;
  }
};

}  // namespace weft
