#pragma once

#include <cstddef>
#include <vector>

#include "host/untangle/contour.hpp"

namespace weft {

/// The same surfaces with cloth of fewer triangles, and how their motion carries over.
///
/// Vertices of cloth are removed one by one, each by a collapse into a neighbour, until some
/// number of triangles is left. Those of one pass are not neighbours, and the ones with the
/// smallest surroundings go first, so that edges grow alike. Kept are vertices at which the cloth
/// is not manifold, those that do not move beside some that do, corners of borders, and those at
/// which the remaining triangles would turn by much or be slender. Obstacles stay as they are.
/// @cite kobbelt1998, meshes of several resolutions by removal of vertices
class CoarseSurfaces {
 public:
  /// @param fine   what is known of the rest is left out
  /// @param wanted triangles of cloth; more are left where no more vertices can go
  CoarseSurfaces(const IntersectingSurfaces& fine, Index wanted);

  IntersectingSurfaces& surfaces() { return coarse_; }

  /// Which coarse points are marked, or have a share in the motion of a fine one that is.
  /// @param fine [fine points]
  /// @return     [coarse points]
  std::vector<unsigned char> marked(std::vector<unsigned char> fine) const;

  /// Moves the fine points by the motion of the coarse ones. A removed vertex takes the mean motion
  /// of the neighbours it had when it was removed, weighted by mean value coordinates; at a border,
  /// by its distances from the two that are next to it there.
  /// @param points [fine points] [m] as given to the constructor
  void carry_over(std::vector<Vec3<double>>& points) const;

 private:
  struct Share {
    Index point;  ///< a fine one
    double weight;
  };
  struct Removed {
    Index point;
    std::size_t first, last;  ///< into shares_
  };
  class Decimation;

  IntersectingSurfaces coarse_;
  std::vector<Vec3<double>> start_;  ///< [coarse points] [m]
  std::vector<Index> kept_;          ///< [coarse points] the fine point that each is
  std::vector<Removed> removed_;     ///< in the order of removal
  std::vector<Share> shares_;
};

}  // namespace weft
