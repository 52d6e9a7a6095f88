#pragma once

#include <array>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// What may become of a vertex, see SurfaceMesh::kept.
enum Keeping : unsigned char {
  free_to_go,
  always_kept,     ///< for example named by a handle
  kept_as_corner,  ///< named by pins alone: may go where a straight edge of theirs stays
};

/// Cloth, material and group of a triangle. Triangles with the same values share one kind.
struct TriangleKind {
  Index cloth = 0;
  Index material = 0;
  Index group = -1;      ///< -1: none
  double density = 0.2;  ///< [kg/m^2]
};

/// Triangle mesh in plain arrays, for splits, flips and collapses. Numbers never change: a removed
/// vertex or triangle keeps its place in the arrays and is marked as gone. Half-edge 3 t + j goes
/// from corner j of triangle t to the next corner.
struct SurfaceMesh {
  // vertices
  std::vector<Vec3<double>> positions;            ///< [m]
  std::vector<Vec3<double>> velocities;           ///< [m/s]
  std::vector<Vec3<double>> previous_velocities;  ///< [m/s] one step ago; empty: not needed
  std::vector<Vec3<double>> starts;               ///< [m] at time 0
  std::vector<double> mass;                       ///< [kg]
  std::vector<Index> hold;           ///< set of pins that hold it, see PinSets; 0: none
  std::vector<unsigned char> kept;   ///< Keeping
  std::vector<unsigned char> heavy;  ///< 1: pinned or sewn, so its velocity must not change
  std::vector<Index> place;          ///< equal for vertices that are welded
  /// [vertices before the remesh] equal for vertices that are welded once all seams are; -1: on
  /// none
  std::vector<Index> sewn;
  std::vector<Index> leaving;                 ///< a half-edge that starts at it; -1: it is gone
  std::vector<std::array<Index, 2>> parents;  ///< ends of the split edge; itself twice: original
  // material points: one per vertex, several where panels meet
  std::vector<Vec2<double>> material;  ///< [m]
  std::vector<Mat2<double>> metric;    ///< [1/m^2] sizing tensor
  // triangles
  std::vector<Tri> triangles;
  std::vector<Tri> corners;           ///< into `material`
  std::vector<Index> kind;            ///< into `kinds`; -1: the triangle is gone
  std::vector<Index> twin;            ///< [half-edges] the one across; -1: none
  std::vector<unsigned char> locked;  ///< [half-edges] 1: the edge lies on a seam and must stay
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

  /// The half-edges that start at a vertex, counter-clockwise. At a boundary vertex, the list
  /// begins at the boundary.
  std::vector<Index> star(Index vertex) const;

  /// Whether the edge is part of a boundary, of a seam within the cloth, or of a border between two
  /// materials or groups. Such edges are never flipped.
  bool is_border(Index h) const;

  /// Twice the area in material space. [m^2]
  double material_det(const Tri& corner) const;
  double triangle_mass(Index t) const;  ///< [kg]

  double total_mass() const;      ///< [kg] of the triangles
  Vec3<double> momentum() const;  ///< [kg m/s] of the vertices
};

/// Fills `twin`, `leaving` and `mass` from the triangles. Marks vertices at which several fans of
/// triangles meet as kept.
/// @pre manifold edges, consistent orientation
void connect(SurfaceMesh& mesh);

/// Splits the edge of `h` in the middle, and the triangles on both sides. Position, velocity and
/// metric of the new vertex are the means of the two ends, which preserves momentum.
/// @param single positions are rounded to single precision
/// @return the new vertex; `touched` gets the triangles that changed or are new
Index split_edge(SurfaceMesh& mesh, Index h, bool single, std::vector<Index>& touched);

/// Undoes the last split_edge().
/// @param vertex, touched as split_edge() returned them
void undo_split(SurfaceMesh& mesh, Index h, Index vertex, const std::vector<Index>& touched);

/// Replaces the edge of `h` by one between the two corners opposite it.
/// @pre not is_border(h)
void flip_edge(SurfaceMesh& mesh, Index h);

/// How a collapse changes the triangles around the vertex that it removes.
struct CollapseResult {
  std::vector<Index> gone;     ///< triangles at the edge, which vanish
  std::vector<Index> changed;  ///< the others around the removed vertex
  std::vector<Tri> triangles;  ///< [changed] their new corners
  std::vector<Tri> corners;    ///< [changed] in material space
};

/// Plans a collapse that moves the start of `h` to its end.
/// @return false if the result would not be a manifold surface, or would have a different
///         outline, seams or borders
bool plan_collapse(const SurfaceMesh& mesh, Index h, CollapseResult& result);

/// Does a planned collapse.
void collapse_edge(SurfaceMesh& mesh, Index h, const CollapseResult& plan);

}  // namespace weft
