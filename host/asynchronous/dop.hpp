#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "weft/core/vec.hpp"

namespace weft {

/// Number of axes of a 26-DOP: 3 along coordinates, 4 along the diagonals of a cube, 6 along those
/// of its faces; 3 more are empty and fill whole registers.
inline constexpr int dop_axes = 16;

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
  out[13] = out[14] = out[15] = 0;
}

/// Length of an axis.
inline constexpr float dop_length[dop_axes] = {
    1,          1,          1,          1.7320508F, 1.7320508F, 1.7320508F, 1.7320508F, 1.4142135F,
    1.4142135F, 1.4142135F, 1.4142135F, 1.4142135F, 1.4142135F, 1,          1,          1};

/// The extent of points along the axes. Empty at first.
struct Extent {
  double lo[dop_axes];
  double hi[dop_axes];

  Extent() {
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
  /// Includes all points that are no farther away than a distance from some that are in. [m]
  void widen(double distance) {
    constexpr double rounded = 1 + 4.0 * std::numeric_limits<float>::epsilon();
    for (int k = 0; k < dop_axes; ++k) {
      lo[k] -= distance * (rounded * dop_length[k]);
      hi[k] += distance * (rounded * dop_length[k]);
    }
  }
};

/// Polytope with sides across fixed axes, in single precision rounded outwards: as large as two
/// lines of a cache. Empty at first.
struct alignas(64) Dop {
  float lo[dop_axes];
  float hi[dop_axes];

  Dop() {
    for (int k = 0; k < dop_axes; ++k) {
      lo[k] = std::numeric_limits<float>::infinity();
      hi[k] = -lo[k];
    }
  }
  explicit Dop(const Extent& extent) {
    // Rounding to the nearest misses by half a unit in the last place, and so much more is added.
    constexpr double unit = std::numeric_limits<float>::epsilon();
    constexpr double least = std::numeric_limits<float>::min();
    for (int k = 0; k < dop_axes; ++k) {
      lo[k] = static_cast<float>(extent.lo[k] - (std::abs(extent.lo[k]) * unit + least));
      hi[k] = static_cast<float>(extent.hi[k] + (std::abs(extent.hi[k]) * unit + least));
    }
  }
  void include(const Dop& b) {
    for (int k = 0; k < dop_axes; ++k) {
      lo[k] = std::min(lo[k], b.lo[k]);
      hi[k] = std::max(hi[k], b.hi[k]);
    }
  }
  /// Whether a gap along some axis shows that the two are farther apart than a distance.
  /// @param distance [m] as dop_distance() gives it, so that rounding shows no gap too many
  bool farther(const Dop& b, float distance) const {
    int gaps = 0;
    for (int k = 0; k < dop_axes; ++k) {
      const float gap = distance * dop_length[k];
      gaps |= static_cast<int>(lo[k] - b.hi[k] > gap) | static_cast<int>(b.lo[k] - hi[k] > gap);
    }
    return gaps != 0;
  }
  /// A distance that the two are apart at least; below zero it says nothing. [m]
  double gap(const Dop& b) const {
    constexpr int width = 8;
    static_assert(dop_axes == 2 * width);
    float most[width];
    for (int k = 0; k < width; ++k) {
      float sides[2];
      for (int j = 0; j < 2; ++j) {
        const int axis = k + j * width;
        const float above = lo[axis] - b.hi[axis], below = b.lo[axis] - hi[axis];
        sides[j] = (above > below ? above : below) / dop_length[axis];
      }
      most[k] = sides[0] > sides[1] ? sides[0] : sides[1];
    }
    // Rounding may have made a difference or a quotient larger than it is.
    constexpr double share = 1 - 4.0 * std::numeric_limits<float>::epsilon();
    return share * double(*std::max_element(most, most + width));
  }
};

/// A distance for Dop::farther(), larger by what a difference, a product and the length of an axis
/// are rounded by.
inline float dop_distance(double distance) {
  return static_cast<float>(distance * (1 + 4.0 * std::numeric_limits<float>::epsilon()));
}

}  // namespace weft
