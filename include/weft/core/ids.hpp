#pragma once

#include <cstdint>

namespace weft {

/// Number of a vertex, edge, triangle, row or rank. 32 bits hold the largest mesh that fits a GPU.
using Index = std::int32_t;

/// Offset into arrays that hold several entries a vertex (matrix values, workload prefix sums).
using Offset = std::int64_t;

/// Corners of a triangle, counter-clockwise seen from its front.
struct Tri {
  Index v[3];
};

/// Ends of an edge, v[0] < v[1].
struct Edge {
  Index v[2];
};

/// Two triangles that share an edge: v[0], v[1] on the edge, v[2] and v[3] opposite it. With the
/// edge seen from v[0] to v[1], triangle (v[0], v[1], v[2]) is counter-clockwise, and so is
/// (v[1], v[0], v[3]).
struct Hinge {
  Index v[4];
};

}  // namespace weft
