#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

#include "host/geometry/aabb.hpp"
#include "host/input/checker.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/scene/defaults.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

/// A mass per area that is more likely in g/m^2 [kg/m^2].
constexpr double least_in_grams = 60, most_in_grams = 2000;

/// Degrees of the usual angle that is this number of radians, to within a thousandth; 0: none.
double degrees_of_radians(double angle) {
  for (const double degrees : {30, 45, 60, 90, 180, 270, 360})
    if (std::abs(std::abs(angle) * (180 / std::numbers::pi) - degrees) <= 1e-3 * degrees)
      return std::copysign(degrees, angle);
  return 0;
}

/// @param path of the value
void warn_of_radians(const json& value, const std::string& path, Scene& scene) {
  if (value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i)
      warn_of_radians(value[i], path + "[" + std::to_string(i) + "]", scene);
  if (!value.is_object()) return;
  for (const auto& [key, part] : value.items()) {
    const std::string inner = path.empty() ? key : path + "." + key;
    if (key != "rotate") {
      warn_of_radians(part, inner, scene);
      continue;
    }
    if (!part.is_array() || part.empty() || !part[0].is_number()) continue;
    const double angle = part[0].get<double>();
    if (const double degrees = degrees_of_radians(angle); degrees != 0)
      scene.warnings.push_back(inner + ": " + short_text(part) + " turns by " + text_of(angle) +
                               " degrees; if these are radians, write " + text_of(degrees));
  }
}

void warn_of_large_grids(const json& resolved, const std::vector<ClothGroup>& groups,
                         Scene& scene) {
  // Behind the groups of "cloths" are those of garments.
  const json& cloths = resolved.at("cloths");
  for (std::size_t i = 0; i < cloths.size(); ++i) {
    const json& cloth = cloths[i];
    if (cloth.contains("mesh") || cloth.at("transform").at("scale") != 1) continue;
    const Vec3<double> extents = aabb_of(scene.cloths[at(groups[i].first)].mesh.positions).size();
    const double size = std::max({extents[0], extents[1], extents[2]});
    if (may_be_in_other_units(size))
      scene.warnings.push_back(numbered("cloths", i) + ": it is " + rounded_text(size) +
                               " m large; lengths in a scene are in metres");
  }
}

}  // namespace

void warn_of_mistakes(const json& resolved, const std::vector<ClothGroup>& groups, Scene& scene) {
  warn_of_large_grids(resolved, groups, scene);
  for (const Material& material : scene.materials)
    if (material.density >= least_in_grams && material.density <= most_in_grams)
      scene.warnings.push_back(
          "materials." + material.name + ".density: " + text_of(material.density) +
          " kg/m^2; if these are g/m^2, write " + text_of(material.density / 1000));
  const TimeSettings& time = scene.time;
  if (!time.automatic && time.step * time.frame_rate > 1 + 1e-9)
    scene.warnings.push_back("time.step: " + text_of(time.step) + " s is longer than a frame of " +
                             rounded_text(1 / time.frame_rate) + " s, which is taken in one step");
  const double thickness = thickness_of(scene), edge = mean_cell_edge(scene.cloths);
  if (thickness > 1.01 * edge)  // beyond rounding
    scene.warnings.push_back("contact.thickness: " + text_of(thickness) +
                             " m is more than the cells of the cloths, " + rounded_text(edge) +
                             " m; it is where contact begins, some 0.001 m for a fabric");
  warn_of_radians(resolved, "", scene);
}

}  // namespace weft::io
