#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "weft/core/vec.hpp"

namespace weft {

/// Axis-aligned box [m]; empty at first.
struct Aabb {
  Vec3<double> lo{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                  std::numeric_limits<double>::infinity()};
  Vec3<double> hi = -lo;

  bool empty() const { return !(lo[0] <= hi[0]); }
  void include(const Vec3<double>& x) { include(x, x); }
  void include(const Aabb& box) { include(box.lo, box.hi); }
  /// Widens the box to hold all between two corners.
  void include(const Vec3<double>& low, const Vec3<double>& high) {
    for (int c = 0; c < 3; ++c) {
      lo[c] = std::min(lo[c], low[c]);
      hi[c] = std::max(hi[c], high[c]);
    }
  }
  /// Whether the boxes have a point in common, their sides included.
  bool overlaps(const Aabb& b) const {
    for (int c = 0; c < 3; ++c)
      if (lo[c] > b.hi[c] || b.lo[c] > hi[c]) return false;
    return true;
  }
  Vec3<double> center() const { return 0.5 * (lo + hi); }
  Vec3<double> size() const { return empty() ? Vec3<double>{} : hi - lo; }
  double diagonal() const { return length(size()); }
  double longest_side() const {
    const Vec3<double> s = size();
    return std::max({s[0], s[1], s[2]});
  }
  /// Sum of the sides along x, y and z.
  double girth() const {
    const Vec3<double> s = size();
    return s[0] + s[1] + s[2];
  }
};

/// Box around points.
inline Aabb aabb_of(const std::vector<Vec3<double>>& points) {
  Aabb box;
  for (const Vec3<double>& x : points) box.include(x);
  return box;
}

}  // namespace weft
