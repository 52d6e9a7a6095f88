#pragma once

#include <array>

#include "weft/scene.hpp"

/// Meshes made from numbers. All are manifold, without duplicate vertices, consistently oriented,
/// and a pure function of their arguments.
namespace weft {

enum class Diagonals {
  alternating,  ///< neighbouring cells are mirrored, so that no direction is preferred
  same          ///< every cell is split from its lower left to its upper right corner
};

/// Number of the vertex at column i, row j of a grid of nx columns of cells.
constexpr Index grid_vertex(Index nx, Index i, Index j) {
  return j * (nx + 1) + i;
}

/// Rectangle in the xy plane, centred on the origin, front towards +z, (nx + 1) x (ny + 1) vertices
/// row by row from (-w/2, -h/2), x first. Material coordinates are its own xy.
/// @param size  [m] width and height, > 0
/// @param cells number of cells along x and y, >= 1; two triangles a cell
/// @pre the vertex count fits Index
Mesh make_grid(const Vec2<double>& size, const std::array<Index, 2>& cells, Diagonals diagonals);

/// Sphere about the origin: an icosahedron, each triangle split in four `subdivisions` times, all
/// vertices at `radius`; closed, front outwards, 20 * 4^subdivisions triangles, no material.
/// @param radius       [m] > 0
/// @param subdivisions 0 to 10
Mesh make_icosphere(double radius, int subdivisions);

/// Box about the origin with sides along the axes; closed, front outwards, no material.
/// @param size  [m] > 0
/// @param cells number of cells along x, y and z, >= 1; two triangles a cell of each side
/// @pre the vertex count fits Index
Mesh make_box(const Vec3<double>& size, const std::array<Index, 3>& cells);

/// Mean edge length of make_icosphere(1, subdivisions), to within 5 %.
double icosphere_edge(int subdivisions);

}  // namespace weft
