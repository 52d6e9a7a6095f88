#pragma once

#include <vector>

#include "host/adaptive/remesh_parts.hpp"
#include "host/adaptive/surface_mesh.hpp"
#include "host/geometry/box_forest.hpp"
#include "host/geometry/culling_planes.hpp"
#include "host/geometry/triangle_pair.hpp"

namespace weft {

/// Tests whether new triangles would touch other triangles or come too close to them. Its tree of
/// boxes follows the changes of the mesh.
class Clearance {
 public:
  /// @param mesh, around must outlive this
  /// @param reach [m] largest reach that nearest_obstacle() will get
  Clearance(const SurfaceMesh& mesh, const Surroundings& around, double reach);

  /// Whether new triangles can replace old ones. They must not touch each other, or another
  /// triangle of cloth or obstacle, and must keep the gap to the latter.
  /// @param fresh corners of the new triangles
  /// @param gone  numbers of the triangles that they replace
  /// @param keep_gap false: only touching counts, not the gap
  bool is_clear(const std::vector<Tri>& fresh, const std::vector<Index>& gone, bool keep_gap) const;

  /// Updates the tree after these triangles were added, changed or removed.
  void update(const std::vector<Index>& triangles);

  /// Plane through the obstacle point that is nearest to a given point.
  struct Plane {
    Vec3<double> point;
    Vec3<double> normal;  ///< unit, towards the given point; zero: none within reach
    Index triangle = -1;  ///< -1: none within reach
  };
  /// @param guess a triangle that may be near, tested first; -1: none. It changes no result.
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
    Aabb box;
  };
  mutable std::vector<Near> near_, fresh_;  ///< working memory of is_clear()
};

}  // namespace weft
