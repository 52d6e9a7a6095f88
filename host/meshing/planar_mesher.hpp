#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// A part of the plane as triangles, all counter-clockwise.
struct PlanarMesh {
  std::vector<Vec2<double>> points;  ///< [m] first those of the outline, in its order
  std::vector<Tri> triangles;
};

/// Two sides of an outline that cross or touch each other. Side k runs from point k to the next.
using OutlineCrossing = std::array<std::size_t, 2>;

/// @param outline [m] points of a closed polygon in the plane, without the first one at the end
/// @return the first two sides that have more in common than the point between neighbours, or
///         nothing. Points closer than 2^-22 of the outline's size count as one.
/// @pre at least 3 points, finite
std::optional<OutlineCrossing> find_crossing(const std::vector<Vec2<double>>& outline);

/// [m^2] > 0: the outline runs counter-clockwise
double signed_area(const std::vector<Vec2<double>>& outline);

/// Smallest angle that refinement aims at. [degrees]
inline constexpr double least_mesh_angle = 25;

/// Fills an outline with triangles that have nearly equal sides. The outline gets no further
/// points, so that outlines which share a side stay sewable. Points within start on a hexagonal
/// lattice; a constrained Delaunay triangulation is then smoothed and refined, in a bounded number
/// of rounds, where angles are small. A pure function of its arguments.
/// @param outline [m] counter-clockwise, sides about as long as `edge`
/// @param edge    [m] length of edges that is aimed at, > 0
/// @pre find_crossing() finds none, signed_area() > 0, and most_mesh_points() fits Index
PlanarMesh mesh_outline(const std::vector<Vec2<double>>& outline, double edge);

/// How many points a mesh may get.
double most_mesh_points(const std::vector<Vec2<double>>& outline, double edge);

/// Smallest angle of a triangle. [degrees]
double least_angle(const Vec2<double>& a, const Vec2<double>& b, const Vec2<double>& c);

}  // namespace weft
