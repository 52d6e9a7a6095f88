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
Mesh make_grid(const Vec2<double>& size, const std::array<Index, 2>& cells,
               Diagonals diagonals = Diagonals::alternating);

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

/// Capsule about the origin, its axis along z: a tube with half a sphere at either end; closed,
/// front outwards, no material. All triangles are nearly equilateral: each cap is made of `rings`
/// rings around its pole, ring k of 5 k vertices, and the tube of rows that are staggered. A tube
/// shorter than half a row has no row of its own: the caps meet in the ring between them.
/// @param radius [m] > 0
/// @param length [m] of the tube, >= 0; the whole is `length + 2 radius` long
/// @param rings  of each cap, >= 1
/// @pre the vertex count fits Index
Mesh make_capsule(double radius, double length, Index rings);

/// How many triangles make_capsule() makes.
double capsule_triangles(double radius, double length, Index rings);

/// Disc in the xy plane about the origin, front towards +z: `rings` rings around the centre, ring k
/// of 6 k vertices, so that all triangles are nearly equilateral; 6 rings^2 triangles. Vertices
/// ring by ring from the centre, which is number 0. Material coordinates are its own xy.
/// @param radius [m] > 0
/// @param rings  >= 1
/// @pre the vertex count fits Index
Mesh make_disc(double radius, Index rings);

/// Disc with a hole: rings as in make_disc(), from the hole's rim to the outside, the first of
/// them of about as many vertices as makes all triangles nearly equilateral. Vertices ring by ring
/// from the hole.
/// @param inner, outer [m] 0 < inner < outer
/// @param rings        of triangles, >= 1
/// @pre the vertex count fits Index
Mesh make_annulus(double inner, double outer, Index rings);

/// How many sixths of a ring the first ring of make_annulus() has; the last has `rings` more.
Index annulus_start(double inner, double outer, Index rings);

/// Open tube about the z axis, centred on the origin, front outwards: cells[0] x (cells[1] + 1)
/// vertices row by row from the bottom, in each row counter-clockwise from the x axis. Material
/// coordinates are the unrolled rectangle, as wide as the chords around add up to, so that it
/// starts without strain: (cells[0] + 1) x (cells[1] + 1) of them, like a grid's, which
/// `material_triangles` names.
/// @param radius [m] > 0, of the circle on which the vertices lie
/// @param height [m] > 0
/// @param cells  around, >= 3, and along, >= 1; two triangles a cell
/// @pre the counts fit Index
Mesh make_tube(double radius, double height, const std::array<Index, 2>& cells);

/// Mean edge length of make_icosphere(1, subdivisions), to within 5 %.
double icosphere_edge(int subdivisions);

}  // namespace weft
