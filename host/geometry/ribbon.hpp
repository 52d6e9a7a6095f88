#pragma once

#include <array>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// A strip of cloth along a curve in space.
struct Ribbon {
  double width = 0;  ///< [m] > 0
  /// [m] points of its middle line, two or more, no two that follow each other alike; a smooth
  /// curve goes through them (centripetal Catmull-Rom)
  std::vector<Vec3<double>> path;
  /// Unit; everywhere the strip's width is as near to this direction as the curve lets it be.
  Vec3<double> across{0, 0, 1};
};

/// [m] of the middle line
double ribbon_length(const Ribbon& ribbon);

/// The smallest sine of the angle between the curve and `across`, over the curve: at 0 the strip
/// has no side.
double ribbon_steepness(const Ribbon& ribbon);

/// Mesh of a ribbon: a grid of cells[0] x cells[1] cells, along and across, numbered as by
/// make_grid(); front on the side of path x across. Material coordinates are the straight strip, so
/// that where the curve bends within the strip's surface it starts strained.
/// @param cells >= 1 each; two triangles a cell, mirrored from cell to cell
/// @pre ribbon_steepness(ribbon) > 0, and the vertex count fits Index
Mesh make_ribbon(const Ribbon& ribbon, const std::array<Index, 2>& cells);

}  // namespace weft
