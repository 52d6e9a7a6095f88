#pragma once

#include <array>
#include <vector>

#include "weft/scene.hpp"

/// Meshes made from an outline. All are manifold, without duplicate vertices, consistently
/// oriented, and a pure function of their arguments.
namespace weft {

/// How far a panel reaches to both sides at one height.
struct PanelWidth {
  double height = 0;  ///< [m] y
  double left = 0;    ///< [m] least x
  double right = 0;   ///< [m] greatest x, > left
};

/// Piece of a pattern between two outlines in the xy plane, front towards +z: a grid of cells[0] x
/// cells[1] cells, row by row from the bottom, whose rows are stretched between the outlines, which
/// are straight between the heights. Every height of the outline is that of a row. Material
/// coordinates are its own xy.
/// @param outline two or more, heights increasing
/// @param cells   along x, >= 1, and along y, at least one between two heights
/// @pre the vertex count fits Index
Mesh make_panel(const std::vector<PanelWidth>& outline, const std::array<Index, 2>& cells);

/// [m^2]
double panel_area(const std::vector<PanelWidth>& outline);

/// Surface of revolution about the z axis.
struct Revolution {
  std::vector<Vec2<double>> profile;  ///< [m] radius, >= 0, and z; two or more, no two alike
  bool closed = false;                ///< the last point is joined to the first: a ring
};

/// True if points of radius 0 stand at the ends of an open profile only, and no two that follow
/// each other are alike.
bool can_revolve(const Revolution& shape);

/// Mesh of a surface of revolution, of nearly square cells split in two; a point of the profile on
/// the axis is a pole. A closed profile has its front outwards, whichever way it runs; an open one
/// has it outwards where it runs upwards.
/// @param around vertices around, >= 3
/// @param edge   [m] length of cells along the profile that is aimed at, > 0
/// @pre can_revolve(shape), and the vertex count fits Index
Mesh make_revolution(const Revolution& shape, Index around, double edge);

/// How many triangles make_revolution() makes at most; around a pole it needs half as many.
double revolution_triangles(const Revolution& shape, Index around, double edge);

}  // namespace weft
