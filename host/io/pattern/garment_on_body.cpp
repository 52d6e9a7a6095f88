#include "host/io/pattern/garment_on_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/geometry/aabb.hpp"
#include "host/input/quantity.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr int slices = 50;
/// Sizes of all panels together over that of the body: a bow tie and a dress with a train fit in.
constexpr double smallest_garment = 0.1;
constexpr double largest_garment = 5;

std::string to_millimetres(double metres) {
  return short_number(std::round(1000 * metres) / 1000);
}

}  // namespace

double height_around_body(const Garment& garment, const Mesh& body) {
  Aabb around = aabb_of(garment.mesh.positions);
  const double low = around.lo[1], slice = around.size()[1] / slices;
  for (const int axis : {0, 2}) {
    around.lo[axis] -= most_panel_distance;
    around.hi[axis] += most_panel_distance;
  }
  std::array<bool, slices> has_body{};
  for (const Tri& t : body.triangles) {
    Aabb box;
    for (const Index v : t.v) box.include(body.positions[at(v)]);
    if (!around.overlaps(box)) continue;
    for (int k = 0; k < slices; ++k)
      if (box.lo[1] <= low + slice * (k + 1) && box.hi[1] >= low + slice * k)
        has_body[at(k)] = true;
  }
  return static_cast<double>(std::count(has_body.begin(), has_body.end(), true)) / slices;
}

void refuse_other_size(const Garment& garment, const Mesh& body, const nlohmann::json& document,
                       const std::string& file) {
  const double size = aabb_of(garment.mesh.positions).longest_side();
  const double body_size = aabb_of(body.positions).longest_side();
  if (size >= smallest_garment * body_size && size <= largest_garment * body_size) return;
  // Panels of a drawing have its unit.
  const bool drawn = document.at("pattern").contains("outlines");
  const nlohmann::json::json_pointer unit(drawn ? "/pattern/outlines_unit"
                                                : "/properties/units_in_meter");
  const std::string value =
      document.contains(unit) ? short_text(document.at(unit)) : std::string("missing");
  throw SceneError(file, drawn ? "pattern.outlines_unit" : "properties.units_in_meter",
                   value + ", which makes a garment of " + to_millimetres(size) +
                       " m for a body of " + to_millimetres(body_size) + " m",
                   "panels that together are " + short_number(smallest_garment) + " to " +
                       short_number(largest_garment) + " times as large as the body");
}

}  // namespace weft::io
