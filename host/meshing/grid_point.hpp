#pragma once

#include <cstdint>

namespace weft {

/// A point of the plane with whole coordinates, so that the signs below are exact.
struct GridPoint {
  std::int64_t x = 0;
  std::int64_t y = 0;
  friend bool operator==(const GridPoint&, const GridPoint&) = default;
};

/// Largest magnitude of a coordinate. Products of four differences of such numbers fit 128 bits.
inline constexpr std::int64_t grid_limit = std::int64_t{1} << 26;

/// Twice the signed area of a triangle.
/// @return > 0: a, b, c turn left; 0: they lie on one line
/// @pre coordinates within grid_limit
constexpr std::int64_t orientation(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Whether d lies inside the circle through a, b and c.
/// @pre a, b, c turn left; coordinates within grid_limit
bool in_circle(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d);

}  // namespace weft
