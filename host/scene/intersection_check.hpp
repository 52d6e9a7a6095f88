#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Refuses a scene that contact handling could not start from. At time 0, with obstacles deformed
/// and placed as they are then:
///   - no two triangles of cloth, of one cloth or of two, may intersect (only if contact.self);
///   - no triangle of cloth may intersect one of an obstacle;
///   - no connected part of a cloth may lie inside an obstacle whose surface is closed, that is
///     where the winding number exceeds 1/2 (an inside-out surface, such as a room, has none).
/// Triangles intersect if an edge of one pierces the other, or if a vertex and a face, or two
/// edges, are no farther apart than 1e-12 of the size of the triangles: repulsion needs a gap.
/// Features that share a vertex are not compared, so neighbours intersect only where they overlap
/// beyond their common vertex or edge. Piercing is decided in exact arithmetic. Obstacles may
/// intersect each other.
/// Vertices that seams have made one at the start count as one, at the mean of their places.
/// @pre validate(scene) passes
/// @param welded see make_model
/// @param note   what else to say where triangles intersect, such as what was tried
/// @throws SceneError that names the cloth, the first few pairs by triangle numbers within their
///         own meshes, and the number of pairs
void refuse_intersecting_start(const Scene& scene, const std::vector<unsigned char>& welded = {},
                               const std::string& note = {});

}  // namespace weft
