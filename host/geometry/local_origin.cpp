#include "host/geometry/local_origin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft {
namespace {

constexpr double zero_within = 4;      // [sizes] of the middle
constexpr double always_within = 0.5;  // [sizes]
/// Few numbers lie so near to a round one by chance.
constexpr double rounder_than_distance = 16;

/// See local_origin().
/// @pre finite; size > 0, and adding half of it changes `middle`
double roundest_near(double middle, double size) {
  if (std::abs(middle) <= zero_within * size) return 0;
  for (int power = std::ilogb(middle) + 1;; --power) {
    const double multiple = std::ldexp(std::round(std::ldexp(middle, -power)), power);
    const double distance = std::abs(multiple - middle);
    if (distance <= always_within * size ||
        (distance <= zero_within * size &&
         rounder_than_distance * distance <= std::ldexp(1.0, power)))
      return multiple;
  }
}

}  // namespace

Vec3<double> local_origin(const std::vector<const std::vector<Vec3<double>>*>& positions) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3<double> low{infinity, infinity, infinity};
  Vec3<double> high{-infinity, -infinity, -infinity};
  bool finite = true;
  for (const auto* surface : positions)
    for (const Vec3<double>& x : *surface)
      for (int k = 0; k < 3; ++k) {
        finite = finite && std::isfinite(x[k]);
        low[k] = std::min(low[k], x[k]);
        high[k] = std::max(high[k], x[k]);
      }
  double size = 0;
  for (int k = 0; k < 3; ++k) size = std::max(size, high[k] - low[k]);
  if (!finite || !(size > 0)) return {0, 0, 0};
  Vec3<double> origin{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const double middle = low[k] + (high[k] - low[k]) / 2;
    const double half = always_within * size;
    // Farther away, the surfaces are but a few places of a double wide: nothing is to be gained.
    if (middle - half < middle && middle < middle + half) origin[k] = roundest_near(middle, size);
  }
  return origin;
}

void move_origin(std::vector<Vec3<double>>& positions, const Vec3<double>& from,
                 const Vec3<double>& to) {
  if (from == to) return;
  const Vec3<double> offset = from - to;
  for (Vec3<double>& x : positions) x += offset;
}

}  // namespace weft
