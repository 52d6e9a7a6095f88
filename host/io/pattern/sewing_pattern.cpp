#include "host/io/pattern/sewing_pattern.hpp"

#include <cmath>
#include <numbers>

#include "host/input/safe_text.hpp"

namespace weft::io {

Vec3<double> placed(const PatternPanel& panel, const Vec2<double>& point) {
  Vec3<double> x{point[0], point[1], 0};
  for (int axis = 0; axis < 3; ++axis) {
    const double angle = panel.rotation[axis] * std::numbers::pi / 180;
    const double c = std::cos(angle), s = std::sin(angle);
    const int j = (axis + 1) % 3, k = (axis + 2) % 3;
    const double along = x[j], across = x[k];
    x[j] = c * along - s * across;
    x[k] = s * along + c * across;
  }
  return x + panel.translation;
}

std::string field_of(const SewingPattern& pattern, const PatternSide& side) {
  return "pattern.panels." + one_line(pattern.panel(side).name) + ".edges[" +
         std::to_string(side.edge) + "]";
}

}  // namespace weft::io
