#pragma once

#include <vector>

#include "host/lab/check/validator.hpp"

/// The search for intersecting pairs, from a tree of boxes to exact tests.
namespace weft::lab {

/// Which triangles of a mesh take part: those with three finite corners.
/// @pre every corner names a position
std::vector<Index> finite_triangles(const Mesh& mesh);

/// Fills `pairs` and both counts of the verdict, by the rules of validate().
/// @param cloth       mesh; `cloth_ids` are its triangles that take part, increasing
/// @param obstacle    mesh or null; the same holds for `obstacle_ids`
/// @pre   every corner names a position
void find_intersections(const Mesh& cloth, const std::vector<Index>& cloth_ids,
                        const Mesh* obstacle, const std::vector<Index>& obstacle_ids,
                        const ValidatorOptions& options, FrameVerdict& verdict);

}  // namespace weft::lab
