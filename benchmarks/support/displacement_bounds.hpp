#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft::bench {

/// How far each vertex may move from where all pairs' distances were taken before any of its pairs
/// can come closer than its separation: half of the least room that a pair of its has, as in offset
/// geometric contact (Chen et al. 2025). While both ends of a straight motion keep to these balls
/// continuous detection has nothing to find. A pair's own certificate lets its corners move
/// together; a vertex' does not, but it is one number a vertex, that holds for all steps until
/// then.
class DisplacementBounds {
 public:
  explicit DisplacementBounds(std::size_t vertices)
      : bounds_(vertices, std::numeric_limits<double>::infinity()) {}

  /// @param v    corners of a pair
  /// @param room [m] that it may come closer by
  void add(const Index v[4], double room) {
    // Half each, less what rounding can do to the sum.
    const double half = std::max(0.0, 0.4999999 * room);
    for (int j = 0; j < 4; ++j) {
      double& bound = bounds_[static_cast<std::size_t>(v[j])];
      bound = std::min(bound, half);
    }
  }

  /// Whether vertex v may be at x.
  /// @param from [m] where it was when distances were taken
  /// @return     false for what is not a number
  template <class T>
  bool allow(std::size_t v, const Vec3<T>& from, const Vec3<T>& x) const {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      const double d = double(x[c]) - double(from[c]);
      sum += d * d;
    }
    return std::sqrt(sum) <= bounds_[v];
  }
  /// [m] infinite for a vertex without pairs
  double operator[](std::size_t v) const { return bounds_[v]; }

 private:
  std::vector<double> bounds_;
};

}  // namespace weft::bench
