#pragma once

#include <limits>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/distance.hpp"
#include "weft/elements/pair_lanes.hpp"
#include "weft/elements/scalar.hpp"

namespace weft {

/// Distance at rest of two primitives of cloth. Where panels meet, material space may split a
/// primitive. Its distance is then that of its nearest part: an edge that is not cut, or an end of
/// one that is.
/// @tparam First corners of the first primitive: 1 vertex and face, 2 two edges
/// @param x     [m] the corners in material space
/// @param cloth of each corner: material spaces of different cloths have nothing to do with each
///              other
/// @param cut   a bit for each edge with ends that are not their rest length apart in x: of a face
///              bit k for the one opposite its corner k, of edges bit 0 for the first, 1 the second
/// @return      [m^2] infinite where there are no parts of one cloth
template <int First, class T>
WEFT_HD T rest_distance_sq(const Vec3<T> (&x)[4], const Index (&cloth)[4], unsigned cut) noexcept {
  if (cut == 0) {
    for (int j = 1; j < 4; ++j)
      if (cloth[j] != cloth[0]) return std::numeric_limits<T>::infinity();
    return closest_points<First>(x).distance_sq;
  }
  T nearest_sq = std::numeric_limits<T>::infinity();
  const auto compare = [&](int a, int b, int c, int d) {
    if (cloth[b] != cloth[a] || cloth[c] != cloth[a] || cloth[d] != cloth[a]) return;
    const Vec3<T> parts[4] = {x[a], x[b], x[c], x[d]};
    nearest_sq = lesser(nearest_sq, edge_edge(parts).distance_sq);
  };
  const auto compare_edge = [&](int a, int b, int c, int d, bool is_cut) {
    if (!is_cut) return compare(a, b, c, d);
    compare(a, b, c, c);
    compare(a, b, d, d);
  };
  if constexpr (First == 1) {
    for (int k = 0; k < 3; ++k)
      compare_edge(0, 0, 1 + (k + 1) % 3, 1 + (k + 2) % 3, (cut >> k & 1) != 0);
  } else if ((cut & 1) != 0) {
    compare_edge(0, 0, 2, 3, (cut & 2) != 0);
    compare_edge(1, 1, 2, 3, (cut & 2) != 0);
  } else {
    compare_edge(0, 1, 2, 3, true);
  }
  return nearest_sq;
}

}  // namespace weft
