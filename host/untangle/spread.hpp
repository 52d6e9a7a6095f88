#pragma once

#include <vector>

#include "host/untangle/correction.hpp"

// How the surroundings of what has to move come along.

namespace weft {

/// Spreads motions over surfaces, so that cloth moves in large pieces and does not crumple.
class Spreader {
 public:
  /// Lengths of edges as they are now are those that cloth keeps to. Both must outlive it.
  Spreader(const IntersectingSurfaces& surfaces, const SurfaceTopology& topology);

  /// One motion that follows the corrections. Each gives its points a share by weights and inverse
  /// masses; a point takes the mean of what it is given. Others follow: d minimises
  ///   sum over given points of 20 |d - given|^2 + sum over edges |d_i - d_j|^2 + sum |d|^2 / r^2
  /// where r, in edges, grows with the region that is sent back, and points in regions have no last
  /// term, so that what is cut off comes along as a whole. Nothing moves farther than `step` [m].
  /// @return [points] [m]; zero for points that do not move
  std::vector<Vec3<double>> motion(const Corrections& corrections, double step);

  /// Shortens edges near moving points that are longer than they were at first by more than a
  /// tenth, and lengthens those shorter than half, in a few sweeps.
  /// @param moved [points] which to look at
  void relax(const std::vector<unsigned char>& moved, std::vector<Vec3<double>>& points) const;

  /// Sum over edges of the square of what relax() has yet to do, as a share of the first length.
  double stretch(const std::vector<Vec3<double>>& points) const;

 private:
  struct Wish {
    Vec3<double> sum{0, 0, 0};
    double weight = 0;
  };
  void wish(const Corrections& corrections, double step);
  void surround(const Corrections& corrections);
  std::vector<Vec3<double>> solve() const;

  const IntersectingSurfaces& surfaces_;
  const SurfaceTopology& topology_;
  std::vector<double> first_length_;  ///< [edges] [m]
  std::vector<Wish> wishes_;          ///< [points]
  std::vector<double> reach_;         ///< [points] edges, of given points
  std::vector<Index> local_;          ///< [points] place in active_, or -1
  std::vector<Index> active_;         ///< points that may move now
  std::vector<double> drag_;          ///< [active]
};

}  // namespace weft
