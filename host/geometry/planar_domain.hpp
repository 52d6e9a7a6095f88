#pragma once

#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// A triangle over its domain.
struct DomainTriangle {
  Index v[3];
  double inverse[4];  ///< [1/m] row by row: the inverse of the matrix of columns p1 - p0, p2 - p0
};

/// Side of a domain, counter-clockwise, with its normal times its length.
struct DomainSide {
  Index v[2];
  Vec2<double> normal;  ///< [m] outwards
};

/// A connected component of cloth over a convex domain in the plane, which its triangles cover once
/// and without gaps. Then whatever the positions are
///   - the straight line between two points of the domain lies within it;
///   - two primitives that share no vertex are at least `least_gap` apart in it: the line from a
///     vertex v to the closest point of a face that it is no corner of starts in a triangle around
///     v and leaves those triangles through the side opposite to v, so that it is at least as long
///     as that triangle's height over the side; edges are closest at an end of one of them.
struct PlanarDomain {
  std::vector<DomainTriangle> triangles;
  std::vector<DomainSide> sides;
  std::vector<Index> vertices;  ///< ascending
  double least_gap = 0;         ///< [m] the least height of any triangle, rounded down
  double largest_inverse = 0;   ///< [1/m] largest magnitude in any DomainTriangle::inverse
};

/// Domains of all connected pieces, from a picture of each in the plane. Coordinates are first
/// rounded to 2^-20 of the piece's size, which makes another picture, as good as the first, whose
/// orientations can be told without error. A triangle's interior is covered once if all triangles
/// turn the same way, no directed edge is there twice, and the sides form one convex polygon that
/// is run through once: the number of triangles over a point is how often the sides wind around it.
/// @param vertex_count of the cloth
/// @param triangles    of the cloth
/// @param picture      [vertices] [m] such as the material coordinates
/// @return empty if any piece is not of this kind (not convex, of several panels, closed, with a
///         sliver of more than 1 : 1000) or some vertex has no triangle
std::vector<PlanarDomain> planar_domains(Index vertex_count, const std::vector<Tri>& triangles,
                                         const std::vector<Vec2<double>>& picture);

}  // namespace weft
