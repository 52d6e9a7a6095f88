#include "host/geometry/manifold_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <unordered_set>

#include "host/geometry/mesh_check.hpp"

namespace weft {
namespace {

bool has_area(const std::vector<Vec3<double>>& x, const Tri& t) {
  if (t.v[0] == t.v[1] || t.v[1] == t.v[2] || t.v[2] == t.v[0]) return false;
  const auto at = [&](int k) { return x[static_cast<std::size_t>(t.v[k])]; };
  const Vec3<double> a = at(1) - at(0);
  const Vec3<double> b = at(2) - at(0);
  const double longest_sq = std::max({length_sq(a), length_sq(b), length_sq(b - a)});
  // Twice the limit, so that the check after it, which may round otherwise, agrees.
  return length(cross(a, b)) > 2 * min_relative_height * longest_sq;
}

std::uint64_t edge_key(Index from, Index to) {
  return (static_cast<std::uint64_t>(from) << 32) | static_cast<std::uint64_t>(to);
}

}  // namespace

ManifoldMesh make_manifold(const std::vector<Vec3<double>>& positions,
                           const std::vector<Tri>& triangles) {
  ManifoldMesh result;
  std::set<std::array<Index, 3>> seen;
  std::unordered_set<std::uint64_t> taken;  // directed edges
  std::vector<Index> number(positions.size(), -1);
  const auto vertex = [&](Index old) {
    Index& mine = number[static_cast<std::size_t>(old)];
    if (mine < 0) {
      mine = static_cast<Index>(result.source.size());
      result.source.push_back(old);
    }
    return mine;
  };
  for (const Tri& t : triangles) {
    std::array<Index, 3> corners{t.v[0], t.v[1], t.v[2]};
    std::sort(corners.begin(), corners.end());
    if (!has_area(positions, t) || !seen.insert(corners).second) {
      ++result.dropped;
      continue;
    }
    bool free = true;
    for (int k = 0; k < 3; ++k) free = free && !taken.contains(edge_key(t.v[k], t.v[(k + 1) % 3]));
    Tri manifold{};
    for (int k = 0; k < 3; ++k) {
      if (free) {
        taken.insert(edge_key(t.v[k], t.v[(k + 1) % 3]));
        manifold.v[k] = vertex(t.v[k]);
      } else {
        manifold.v[k] = static_cast<Index>(result.source.size());
        result.source.push_back(t.v[k]);
      }
    }
    if (!free) ++result.detached;
    result.triangles.push_back(manifold);
  }
  return result;
}

}  // namespace weft
