#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/geometry/triangle_pair.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Every mesh of the scene at time 0: cloths, then obstacles, each in its input order.
struct Surfaces {
  std::vector<Vec3<double>> points;  ///< [m]
  std::vector<Tri> triangles;
  std::vector<Index> first_point;     ///< [meshes + 1]
  std::vector<Index> first_triangle;  ///< [meshes + 1]

  /// Appends a mesh as the next one.
  void add(const Mesh& mesh);
  Corners corners(Index t) const;      ///< [m] of a triangle
  std::size_t mesh_of(Index t) const;  ///< that a triangle belongs to
};

/// @pre validate(scene) passes
/// @param welded see make_model(); vertices that seams have made one are one, at their mean place
Surfaces surfaces_at_start(const Scene& scene, const std::vector<unsigned char>& welded);

/// Such as "cloths[0] (sheet)"; meshes are counted through cloths, then obstacles.
std::string title_of(const Scene& scene, std::size_t mesh);

/// The name that the scene gives to a mesh, or its field if it gives none.
std::string name_of(const Scene& scene, std::size_t mesh);

/// Whether each edge has two triangles. Meshes that pass check_mesh have none with more.
bool is_closed(const Mesh& mesh);

/// How often the triangles first .. last - 1 wind about x: the sum of their solid angles over 4 pi.
/// With a, b, c from x to the corners,
///   tan(angle / 2) = det[a, b, c] / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)
double winding_number(const Surfaces& surfaces, Index first, Index last, const Vec3<double>& x);

}  // namespace weft
