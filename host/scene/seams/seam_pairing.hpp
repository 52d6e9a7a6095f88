#pragma once

#include <array>
#include <optional>
#include <vector>

#include "host/scene/seams/sewn_mesh.hpp"

namespace weft {

/// Vertices that follow each other along edges of a mesh.
struct VertexChain {
  std::vector<Index> vertices;
  bool closed = false;  ///< the last is a neighbour of the first
};

/// Puts vertices in the order in which they follow each other along the outline of their mesh, or,
/// if they do not lie on it, along its edges. An open chain begins with the end that has the lower
/// number, a closed one with its lowest number.
/// @param mesh has looked at these vertices
/// @return     nothing if they do not make up one chain
std::optional<VertexChain> chain_of(const SewnMesh& mesh, const std::vector<Index>& vertices);

/// Turns a chain so that it runs as its vertices were given.
/// @param given some of its vertices, the first and the last ones too; if it is closed, the first
///              one at the end again
/// @return      nothing if it cannot run that way
std::optional<VertexChain> in_order(const std::vector<Index>& given, VertexChain chain);

/// Whether two chains of one mesh have more in common than vertices at which both of them end.
bool overlap(const VertexChain& a, const VertexChain& b);

/// Pairs the vertices of two chains by their lengths at rest, so that the longer one is gathered
/// evenly. Vertices at nearly the same share of both lengths are a pair. Others get a new vertex as
/// their partner, on an edge of the other chain. Of the directions in which the chains can run, and
/// of the places where a closed one can begin, the pairing has those with the least distances.
/// @param meshes  of the chains; have looked at both of them if they are the same
/// @param keep_direction the first vertices are a pair, and so are the last
/// @return [pairs] on either side, in order; pairs of a vertex with itself are left out, and so is
///         the second one where both chains are closed
/// @pre both chains have a length > 0
std::array<std::vector<Index>, 2> pair_by_length(const std::array<SewnMesh*, 2>& meshes,
                                                 std::array<VertexChain, 2> chains,
                                                 bool keep_direction);

/// [m] at rest
double rest_length(const SewnMesh& mesh, const VertexChain& chain);

}  // namespace weft
