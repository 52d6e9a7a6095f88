#include "host/geometry/local_origin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft {
namespace {

constexpr double sizes_around = 4;

/// The number from `low` to `high` that the largest power of two divides. There is only one: of two
/// neighbouring multiples of a power, one is a multiple of the next.
/// @pre low < high, finite
double roundest_between(double low, double high) {
  if (low <= 0 && high >= 0) return 0;
  for (int power = std::ilogb(std::max(std::abs(low), std::abs(high))) + 1;; --power) {
    const double multiple = std::ldexp(std::ceil(std::ldexp(low, -power)), power);
    if (multiple <= high) return multiple;
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
  const double around = sizes_around * size;
  Vec3<double> origin{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const double middle = low[k] + (high[k] - low[k]) / 2;
    // So far away that the surfaces are but a few places of a double wide: nothing to be gained.
    if (middle - around < middle && middle < middle + around)
      origin[k] = roundest_between(middle - around, middle + around);
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
