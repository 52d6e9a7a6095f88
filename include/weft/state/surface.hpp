#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"

namespace weft {

/// Corners opposite an edge in the first two faces that have it; -1: there is none.
struct EdgeWings {
  Index v[2];
  Index first_face;  ///< lowest number of the faces that have it
};

/// How the faces of cloth and obstacles hang together.
struct Surface {
  Span<const Edge> edges;
  Span<const EdgeWings> wings;       ///< [edges]
  Span<const Tri> edges_of_face;     ///< [faces] numbers of its edges, each opposite that corner
  Span<const Offset> ring_offset;    ///< [vertices + 1]
  Span<const Index> ring;            ///< the vertices that share an edge with each
  Span<const Index> face_of_vertex;  ///< [vertices] lowest number of the faces that have it; -1
};

}  // namespace weft
