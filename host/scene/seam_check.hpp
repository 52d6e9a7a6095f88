#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Checks seams and refinement: references, ranges, pairs, and the surface that sewing makes:
/// - no vertex is sewn to itself, no pair given twice, no two corners of one triangle sewn to each
///   other, be it by way of other vertices;
/// - where two mesh boundary edges are sewn onto each other, their triangles run along them in
///   opposite directions, so that front meets front;
/// - where seams are welded, no two triangles get the same corners.
/// @pre cloths, contact and output have passed their own checks
/// @throws SceneError with the vertices and triangles at fault
void validate_seams(const Scene& scene);

}  // namespace weft
