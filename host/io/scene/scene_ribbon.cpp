#include "host/io/scene/scene_ribbon.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace weft::io {
namespace {

constexpr std::size_t max_points = 10000;
/// Sine of the least angle between path and width.
constexpr double least_steepness = 0.2;

void read_path(Fields& fields, Ribbon& ribbon) {
  for (const std::vector<double>& x : fields.number_lists("path", 3, 3)) {
    const std::string entry = "path[" + std::to_string(ribbon.path.size()) + "]";
    for (const double coordinate : x)
      if (!quantity::coordinate.holds(coordinate))
        fields.refuse(entry, short_text(nlohmann::json(x)),
                      "each " + quantity::coordinate.allowed());
    const Vec3<double> point{x[0], x[1], x[2]};
    if (!ribbon.path.empty() && !(length(point - ribbon.path.back()) >= quantity::least_length))
      fields.refuse(entry, short_text(nlohmann::json(x)),
                    "a point at least 1e-9 m from the one before");
    ribbon.path.push_back(point);
  }
  if (ribbon.path.size() < 2 || ribbon.path.size() > max_points)
    fields.refuse("path", std::to_string(ribbon.path.size()) + " points",
                  "2 to " + std::to_string(max_points) + " points");
}

}  // namespace

Ribbon read_ribbon(Fields& fields) {
  Ribbon ribbon;
  ribbon.width = fields.number("width", quantity::length);
  read_path(fields, ribbon);
  ribbon.across = fields.direction("across", ribbon.across);
  if (!(ribbon_steepness(ribbon) > least_steepness))
    fields.refuse("across", "a direction that the path nowhere comes within 12 degrees of");
  return ribbon;
}

}  // namespace weft::io
