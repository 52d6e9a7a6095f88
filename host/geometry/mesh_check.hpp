#pragma once

#include <string>

#include "weft/scene.hpp"

namespace weft {

/// Where a mesh stands, for messages.
struct MeshOrigin {
  std::string file;   ///< scene or mesh file; may be empty
  std::string field;  ///< such as "cloths[0].mesh"
  std::string name;   ///< of the cloth or obstacle; may be empty
};

/// A triangle counts as having no area if its height over the longest edge is below this share of
/// that edge. Rest shapes that thin cannot be inverted in single precision.
inline constexpr double min_relative_height = 1e-8;

/// Least height over the longest edge of a triangle in material space, in units of that edge, with
/// which the linear solve of an ordinary scene converges: it was seen to fail at 1e-4 in single and
/// at 1e-6 in double precision.
constexpr double least_height(Precision precision) {
  return precision == Precision::single_precision ? 5e-5 : 2e-6;
}

/// Checks a mesh: not empty, counts that fit Index, finite coordinates, indices in range, no
/// repeated corner, no duplicate triangle, no isolated vertex, no edge with more than two triangles
/// or with two that are oriented differently, no triangle without area. With material coordinates
/// also: one a vertex, or else corners of every triangle in range; finite, and every triangle with
/// positive area. Groups in range.
/// @param needs_material refuses a mesh without material coordinates
/// @throws SceneError that names the first few offenders by number
void check_mesh(const Mesh& mesh, const MeshOrigin& origin, bool needs_material);

/// @param least [1] height over the longest edge in material space, see least_height()
/// @pre check_mesh() passes, with material coordinates
/// @throws SceneError that names the first few thinner triangles by number
void check_slivers(const Mesh& mesh, const MeshOrigin& origin, double least);

/// Checks a mesh where it stands in the world: coordinates within quantity::coordinate, and no
/// triangle, in the world or in material space, whose longest edge is below quantity::length.
/// @pre check_mesh() passes
/// @throws SceneError that names the first few offenders by number
void check_size(const Mesh& mesh, const MeshOrigin& origin);

}  // namespace weft
