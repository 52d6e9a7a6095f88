#pragma once

#include <vector>

#include "host/adaptive/remesh_parts.hpp"
#include "host/adaptive/surface_mesh.hpp"
#include "host/geometry/box_forest.hpp"
#include "host/geometry/culling_planes.hpp"
#include "host/geometry/triangle_pair.hpp"

namespace weft {

/// Says whether triangles that are to replace others would meet anything. Keeps a tree of the mesh
/// that is changed along with it.
class Clearance {
 public:
  /// @param mesh must outlive this   @param around must outlive this
  /// @param reach [m] how far nearest_obstacle() will look at most
  Clearance(const SurfaceMesh& mesh, const Surroundings& around, double reach);

  /// Whether triangles can take the place of others: none touches another triangle of cloth or
  /// obstacle, or comes closer than the gap, nor do they touch each other.
  /// @param fresh corners of the new triangles
  /// @param gone  numbers of those that they replace
  /// @param keep_gap whether the gap counts, besides touching
  bool is_clear(const std::vector<Tri>& fresh, const std::vector<Index>& gone, bool keep_gap) const;

  /// The mesh has changed in these triangles.
  void update(const std::vector<Index>& triangles);

  /// Plane of the obstacle triangle that is nearest to a point.
  struct Plane {
    Vec3<double> point;
    Vec3<double> normal;  ///< unit, towards the side of the point; zero: none within reach
    Index triangle = -1;  ///< -1: none within reach
  };
  /// @param guess a triangle that may be near, to look at first; -1: none. It changes no result.
  Plane nearest_obstacle(const Vec3<double>& x, double reach, Index guess = -1) const;

 private:
  Corners corners_of(const Tri& tri) const;
  Tri places_of(const Tri& tri) const;
  Corners obstacle_corners(Index t) const;

  const SurfaceMesh& mesh_;
  const Surroundings& around_;
  BoxForest cloth_;
  BoxForest obstacle_;
  std::vector<unsigned char> in_tree_;  ///< [triangles] whether cloth_ has it
  /// A triangle that may be near, and its box.
  struct Near {
    PlacedTriangle triangle;
    Box box;
  };
  mutable std::vector<Near> near_, fresh_;  ///< of is_clear()
};

}  // namespace weft
