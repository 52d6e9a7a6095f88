#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/scalar.hpp"

// Whether the closest points of two primitives are where their surfaces are closest as well. On a
// surface of triangles the closest point of one triangle may lie on its edge while the neighbour
// beyond that edge is closer still: what lies there is no contact of the surface, and its slanting
// normal would hold back cloth that slides along. A direction that points away from a vertex or an
// edge to what is closest to it lies in its normal cone if going along the surface leads no closer.

namespace weft {

/// Whether going from `from` towards `to` leads no closer to what lies along `away`.
/// @param away  [1] unit vector from the surface to what is closest to it
/// @param slack [1] cosine that counts as a right angle
template <class T>
WEFT_HD bool leads_no_closer(const Vec3<T>& from, const Vec3<T>& to, const Vec3<T>& away,
                             T slack) noexcept {
  const Vec3<T> along = to - from;
  return dot(along, away) <= slack * length(along);
}

/// @param ring      the vertices that share an edge with v
/// @param positions [vertices] [m]   @param away, slack as in leads_no_closer
template <class T>
WEFT_HD bool in_vertex_cone(const Span<const Index>& ring, const Span<const Vec3<T>>& positions,
                            Index v, const Vec3<T>& away, T slack) noexcept {
  const Vec3<T>& from = positions[static_cast<std::size_t>(v)];
  for (std::size_t k = 0; k < ring.size(); ++k)
    if (!leads_no_closer(from, positions[static_cast<std::size_t>(ring[k])], away, slack))
      return false;
  return true;
}

/// @param wings     corners opposite the edge in its faces; -1: there is none
/// @param positions [vertices] [m]   @param away, slack as in leads_no_closer
/// @pre `away` is at right angles to the edge
template <class T>
WEFT_HD bool in_edge_cone(const Edge& edge, const Index (&wings)[2],
                          const Span<const Vec3<T>>& positions, const Vec3<T>& away,
                          T slack) noexcept {
  const Vec3<T>& from = positions[static_cast<std::size_t>(edge.v[0])];
  const Vec3<T> along = positions[static_cast<std::size_t>(edge.v[1])] - from;
  const T along_sq = length_sq(along);
  if (!(along_sq > smallest_normal<T>)) return true;
  for (const Index wing : wings) {
    if (wing < 0) continue;
    const Vec3<T>& corner = positions[static_cast<std::size_t>(wing)];
    const Vec3<T> foot = from + along * (dot(corner - from, along) / along_sq);
    if (!leads_no_closer(foot, corner, away, slack)) return false;
  }
  return true;
}

}  // namespace weft
