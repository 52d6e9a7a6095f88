#include "host/meshing/grid_point.hpp"

namespace weft {
namespace {

__extension__ using Wide = __int128;

}  // namespace

bool in_circle(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d) {
  const std::int64_t ax = a.x - d.x, ay = a.y - d.y;
  const std::int64_t bx = b.x - d.x, by = b.y - d.y;
  const std::int64_t cx = c.x - d.x, cy = c.y - d.y;
  const auto lifted = [](std::int64_t x, std::int64_t y) { return Wide{x} * x + Wide{y} * y; };
  const Wide determinant = lifted(ax, ay) * (Wide{bx} * cy - Wide{by} * cx) -
                           lifted(bx, by) * (Wide{ax} * cy - Wide{ay} * cx) +
                           lifted(cx, cy) * (Wide{ax} * by - Wide{ay} * bx);
  return determinant > 0;
}

}  // namespace weft
