#pragma once

#include <array>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Triangles of which the same may be said: cloth, material and group.
struct TriangleKind {
  Index cloth = 0;
  Index material = 0;
  Index group = -1;      ///< -1: none
  double density = 0.2;  ///< [kg/m^2]
};

/// Surface of triangles that may be split, flipped and collapsed: plain arrays. What is gone keeps
/// its number, and is marked; nothing is ever moved. Half-edge 3 t + j goes from corner j of
/// triangle t to the next.
struct SurfaceMesh {
  // vertices
  std::vector<Vec3<double>> positions;            ///< [m]
  std::vector<Vec3<double>> velocities;           ///< [m/s]
  std::vector<Vec3<double>> previous_velocities;  ///< [m/s] a step ago; empty: nobody asks
  std::vector<Vec3<double>> starts;               ///< [m] at time 0
  std::vector<double> mass;                       ///< [kg]
  std::vector<Index> hold;                    ///< which set of pins holds it, see PinSets; 0: none
  std::vector<unsigned char> kept;            ///< the scene names it: it is never removed
  std::vector<unsigned char> heavy;           ///< its velocity is not to be changed: pinned or sewn
  std::vector<Index> place;                   ///< equal for vertices that seams have made one
  std::vector<Index> leaving;                 ///< a half-edge that starts there; -1: it is gone
  std::vector<std::array<Index, 2>> parents;  ///< that it was put between; twice itself: original
  // material points: one a vertex, several where pieces of a pattern meet
  std::vector<Vec2<double>> material;  ///< [m]
  std::vector<Mat2<double>> metric;    ///< [1/m^2] sizing
  // triangles
  std::vector<Tri> triangles;
  std::vector<Tri> corners;           ///< into `material`
  std::vector<Index> kind;            ///< into `kinds`; -1: the triangle is gone
  std::vector<Index> twin;            ///< [half-edges] the one across; -1: none
  std::vector<unsigned char> locked;  ///< [half-edges] the edge stays as it is: a seam to another
  std::vector<TriangleKind> kinds;

  Index from(Index h) const { return triangles[tri(h)].v[h % 3]; }
  Index to(Index h) const { return triangles[tri(h)].v[(h + 1) % 3]; }
  Index apex(Index h) const { return triangles[tri(h)].v[(h + 2) % 3]; }
  Index corner_from(Index h) const { return corners[tri(h)].v[h % 3]; }
  Index corner_to(Index h) const { return corners[tri(h)].v[(h + 1) % 3]; }
  static Index next(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static Index previous(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }
  static std::size_t tri(Index h) { return static_cast<std::size_t>(h / 3); }
  bool alive(Index t) const { return kind[static_cast<std::size_t>(t)] >= 0; }

  /// The half-edges that start at a vertex, counter-clockwise; at the boundary from there on.
  std::vector<Index> star(Index vertex) const;

  /// Whether the edge is part of a boundary, of a seam within the cloth, or between two materials
  /// or groups: such edges are never turned.
  bool is_border(Index h) const;

  /// Twice the area in material space. [m^2]
  double material_det(const Tri& corner) const;
  double triangle_mass(Index t) const;  ///< [kg]

  double total_mass() const;      ///< [kg] from the triangles
  Vec3<double> momentum() const;  ///< [kg m/s] masses of the vertices times velocities
};

/// Fills twins, leaving half-edges and masses from the triangles; vertices at which several fans of
/// triangles meet are kept.
/// @pre manifold edges, consistent orientation
void connect(SurfaceMesh& mesh);

/// Splits the edge of `h` in the middle, and the triangles at its sides. The new vertex has the
/// mean of all that its ends have, so that momentum is kept.
/// @param single positions are rounded to single precision
/// @return the new vertex; `touched` gets the triangles that changed or are new
Index split_edge(SurfaceMesh& mesh, Index h, bool single, std::vector<Index>& touched);

/// Takes the last split_edge() back.
/// @param touched what it gave
void undo_split(SurfaceMesh& mesh, Index h, Index vertex, const std::vector<Index>& touched);

/// Turns the edge of `h` to join the corners opposite it.
/// @pre not is_border(h)
void flip_edge(SurfaceMesh& mesh, Index h);

/// What a collapse makes of the triangles around the vertex that it removes.
struct CollapseResult {
  std::vector<Index> gone;     ///< triangles at the edge
  std::vector<Index> changed;  ///< the others around the removed vertex
  std::vector<Tri> triangles;  ///< [changed] their new corners
  std::vector<Tri> corners;    ///< [changed] in material space
};

/// Looks at moving the start of `h` into its end.
/// @return false if the surface would not stay one, or change its outline, seams or borders
bool plan_collapse(const SurfaceMesh& mesh, Index h, CollapseResult& result);

/// Does it.
void collapse_edge(SurfaceMesh& mesh, Index h, const CollapseResult& plan);

}  // namespace weft
