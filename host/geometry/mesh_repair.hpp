#pragma once

#include <string>

#include "weft/scene.hpp"

namespace weft {

/// Makes a mesh pass check_mesh() where that can be done without inventing surface, in this order:
/// vertices at exactly one place are joined (their material coordinates stay as they are, a corner
/// each); triangles with a repeated corner or without area, in the world or in material space, are
/// dropped, and so are second triangles of the same three vertices; of an edge with more than two
/// triangles the first two stay; triangles are turned so that neighbours agree, each connected part
/// the way in which most of its triangles have positive area in material space, or without material
/// coordinates stood already; one that closes a one-sided strip is dropped; vertices without a
/// triangle are dropped. If slivers are to go, they do so once triangles are turned
/// (repair_slivers()), and with them triangles without area whose edges have no other two: these
/// are dropped only if they are left then. What is left keeps its order; vertex numbers are those
/// of the result.
/// @param mesh         as read_mesh() returns it
/// @param least_height [1] of a triangle over its longest edge, in units of that edge; 0: slivers
///                     stay
/// @return what was done, as one line such as "joined 4 vertices; dropped 2 triangles without
///         area"; empty if nothing was wrong
std::string repair_mesh(Mesh& mesh, double least_height = 0);

/// Slivers of cloth that repair removes: ten times as thick as what a run in single precision may
/// fail at.
inline constexpr double repaired_height = 1e-3;

}  // namespace weft
