#include "host/geometry/culling_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft {

CullingPlanes::CullingPlanes(const PlacedTriangle& triangle) : t_(triangle) {
  const Corners& x = triangle.x;
  const Vec3<double> edge[3] = {x[1] - x[0], x[2] - x[1], x[0] - x[2]};
  normal_ = cross(edge[0], edge[1]);
  normal_length_ = length(normal_);
  double longest_sq = 0;
  for (int k = 0; k < 3; ++k) {
    outward_[k] = cross(edge[k], normal_);
    length_[k] = length(outward_[k]);
    longest_sq = std::max(longest_sq, length_sq(edge[k]));
  }
  // The least height is twice the area over the longest side, which is no longer than the girth.
  usable_ = normal_length_ > height_share * triangle.girth * std::sqrt(longest_sq);
}

bool CullingPlanes::holds_off(const PlacedTriangle& other, double gap) const {
  if (!usable_ || !(other.girth <= size_ratio * t_.girth)) return false;
  bool shares = false;
  int corner[3] = {-1, -1, -1};  // of this one, at which the other's are
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (other.places.v[i] == t_.places.v[j]) {
        shares = true;
        // One may be shared by its number only, across a seam that is not closed.
        const auto s = static_cast<std::size_t>(i), t = static_cast<std::size_t>(j);
        if (length_sq(other.x[s] - t_.x[t]) == 0) corner[i] = j;
      }
  const double least = clear_share * (t_.girth + other.girth) + (shares ? 0 : gap);
  for (int k = 0; k < 3; ++k) {
    const Vec3<double>& base = t_.x[static_cast<std::size_t>(k)];
    const int end = k == 2 ? 0 : k + 1;
    const double margin = least * length_[k];
    bool beyond = true;
    for (int i = 0; i < 3 && beyond; ++i)
      beyond = corner[i] == k || corner[i] == end ||
               dot(outward_[k], other.x[static_cast<std::size_t>(i)] - base) > margin;
    if (beyond) return true;
  }
  if (shares) return false;
  double low = 0, high = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double h = dot(normal_, other.x[i] - t_.x[0]);
    low = i == 0 ? h : std::min(low, h);
    high = i == 0 ? h : std::max(high, h);
  }
  return std::max(low, -high) > least * normal_length_;
}

}  // namespace weft
