#include "host/geometry/morton.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "host/geometry/aabb.hpp"

namespace weft {
namespace {

/// Spreads the low 21 bits of x to every third bit.
std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

}  // namespace

std::vector<Index> morton_order(const std::vector<Vec3<double>>& points) {
  const Aabb box = aabb_of(points);
  const double extent = std::max(box.longest_side(), 1e-300);
  std::vector<std::uint64_t> code(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double share = (points[i][c] - box.lo[c]) / extent;
      code[i] |= spread_bits(static_cast<std::uint64_t>(share * 2097151.0)) << c;
    }
  std::vector<Index> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
    return code[static_cast<std::size_t>(a)] < code[static_cast<std::size_t>(b)];
  });
  return order;
}

}  // namespace weft
