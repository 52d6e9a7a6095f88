#pragma once

#include <array>
#include <vector>

#include "host/meshing/planar_mesher.hpp"

namespace weft::io {

/// Splits edges within a panel where sewing would make them one with an edge of another place: at
/// the corners of panels that are sewn on both sides, and at the end of a dart or pleat that is one
/// edge deep, triangles would else lie on each other. New points stand in the middle of such edges.
/// @param meshes   of all panels
/// @param outlines [panels] how many of a panel's points, from the first on, are its outline
/// @param first    [panels + 1] number of a panel's first point in `pairs`
/// @param pairs    points that become one
void split_chords(std::vector<PlanarMesh>& meshes, const std::vector<Index>& outlines,
                  const std::vector<Index>& first, const std::vector<std::array<Index, 2>>& pairs);

}  // namespace weft::io
