#include "host/geometry/local_origin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/geometry/aabb.hpp"

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
  Aabb box;
  bool finite = true;
  for (const auto* surface : positions)
    for (const Vec3<double>& x : *surface) {
      finite = finite && std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
      box.include(x);
    }
  const double size = box.longest_side();
  if (!finite || !(size > 0)) return {0, 0, 0};
  Vec3<double> origin{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const double middle = box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
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
