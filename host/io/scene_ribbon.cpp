#include "host/io/scene_ribbon.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace weft::io {
namespace {

constexpr std::size_t max_points = 10000;
constexpr double max_coordinate = 1e9;  ///< [m]
/// Sine of the least angle between path and width.
constexpr double least_steepness = 0.2;

void read_path(Fields& fields, Ribbon& ribbon) {
  for (const std::vector<double>& x : fields.number_lists("path", 3, 3)) {
    const std::string entry = "path[" + std::to_string(ribbon.path.size()) + "]";
    if (!(std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}) <= max_coordinate))
      fields.refuse(entry, short_text(nlohmann::json(x)), "numbers from -1e9 to 1e9");
    const Vec3<double> point{x[0], x[1], x[2]};
    if (!ribbon.path.empty() && !(length(point - ribbon.path.back()) > 0))
      fields.refuse(entry, short_text(nlohmann::json(x)), "another point than the one before");
    ribbon.path.push_back(point);
  }
  if (ribbon.path.size() < 2 || ribbon.path.size() > max_points)
    fields.refuse("path", std::to_string(ribbon.path.size()) + " points",
                  "2 to " + std::to_string(max_points) + " points");
}

}  // namespace

Ribbon read_ribbon(Fields& fields) {
  Ribbon ribbon;
  ribbon.width = fields.positive("width");
  read_path(fields, ribbon);
  const auto across = fields.vector<3>("across", ribbon.across);
  if (!(length(across) > 0 && length(across) <= max_coordinate))
    fields.refuse("across", "a direction");
  ribbon.across = across * (1 / length(across));
  if (!(ribbon_steepness(ribbon) > least_steepness))
    fields.refuse("across", "a direction that the path nowhere comes within 12 degrees of");
  return ribbon;
}

}  // namespace weft::io
