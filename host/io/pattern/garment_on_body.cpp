#include "host/io/pattern/garment_on_body.hpp"

#include <algorithm>
#include <array>

#include "host/geometry/aabb.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

constexpr int slices = 50;

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

}  // namespace weft::io
