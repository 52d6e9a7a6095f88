#pragma once

#include <vector>

#include "host/lab/check/validator.hpp"

/// The state of single triangles: area, orientation in material space, strain.
namespace weft::lab {

/// Numbers of the vertices whose position or material coordinates are not finite.
/// @param material as many as the positions, or none: then positions count alone
/// @param limit    longest list kept
Findings nonfinite_vertices(const std::vector<Vec3<double>>& positions,
                            const std::vector<Vec2<double>>& material, std::size_t limit);

/// Triangles of zero area or with an aspect below 1e-10, see FrameVerdict::degenerate.
/// @param ids triangles to look at, increasing, with finite corners
Findings degenerate_triangles(const Mesh& mesh, const std::vector<Index>& ids, std::size_t limit);

/// Triangles turned over in material space, see FrameVerdict::inverted.
/// @param ids triangles to look at, increasing; those without finite material are passed over
/// @return    nothing for a mesh without material coordinates
Findings inverted_triangles(const Mesh& mesh, const std::vector<Index>& ids, std::size_t limit);

/// Principal stretches minus one: singular values of F = [x1-x0, x2-x0] [m1-m0, m2-m0]^-1.
/// @param ids triangles to look at, with finite corners
StrainVerdict measure_strain(const Mesh& mesh, const std::vector<Index>& ids);

}  // namespace weft::lab
