#include "host/view/view_surface.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace weft {

ViewSurface make_view_surface(std::vector<Tri> triangles, std::vector<Tri> obstacles) {
  struct Side {
    Index low, high, half;  ///< ends, and 3 t + j
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int j = 0; j < 3; ++j) {
      const Index a = triangles[t].v[j], b = triangles[t].v[(j + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(3 * t) + j});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return p.low != q.low ? p.low < q.low : p.high != q.high ? p.high < q.high : p.half < q.half;
  });
  const auto same = [](const Side& p, const Side& q) { return p.low == q.low && p.high == q.high; };
  std::vector<std::array<Index, 3>> across(triangles.size(), {-1, -1, -1});
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && same(sides[i], sides[end])) ++end;
    if (end - i == 2) {
      const Index h = sides[i].half, g = sides[i + 1].half;
      across[static_cast<std::size_t>(h / 3)][static_cast<std::size_t>(h % 3)] = g / 3;
      across[static_cast<std::size_t>(g / 3)][static_cast<std::size_t>(g % 3)] = h / 3;
    }
    i = end;
  }
  return {std::move(triangles), std::move(across), std::move(obstacles)};
}

}  // namespace weft
