#include "host/io/json/transform_fields.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace weft::io {

std::vector<std::string> transform_keys() {
  return {"translate", "rotate", "scale"};
}

void read_rotation(Fields& fields, Transform& transform) {
  const Vec<double, 4> rotate = fields.vector<4>("rotate", Vec<double, 4>{0, 0, 0, 1});
  const Vec3<double> axis{rotate[1], rotate[2], rotate[3]};
  // Divided by the largest component first, so that no square overflows or vanishes.
  const double largest = std::max({std::abs(axis[0]), std::abs(axis[1]), std::abs(axis[2])});
  if (!(largest > 0)) fields.refuse("rotate", "[degrees, x, y, z] with an axis that is not zero");
  const Vec3<double> scaled{axis[0] / largest, axis[1] / largest, axis[2] / largest};
  transform.rotation_axis = scaled * (1.0 / length(scaled));
  if (!quantity::angle.holds(rotate[0]))
    fields.refuse("rotate", "[degrees, x, y, z] with " + quantity::angle.allowed());
  transform.rotation_angle = rotate[0] * (std::numbers::pi / 180);
}

Transform read_transform(Fields& fields) {
  Transform transform;
  transform.translate = fields.vector<3>("translate", quantity::coordinate, Vec3<double>{0, 0, 0});
  read_rotation(fields, transform);
  transform.scale = fields.number("scale", quantity::scale, 1.0);
  return transform;
}

}  // namespace weft::io
