#pragma once

#include "host/geometry/triangle_pair.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// A triangle as those next to it are compared with it.
struct PlacedTriangle {
  Tri places;    ///< numbers of its corners, by which shared ones are known
  Corners x;     ///< [m]
  double girth;  ///< [m] sum of the sides of its box, no less than its longest side
};

/// The planes upright on a triangle along its edges, and its own: most triangles near one that lies
/// in a smooth surface are beyond one of these, which is told in a tenth of the time of a test.
class CullingPlanes {
 public:
  explicit CullingPlanes(const PlacedTriangle& triangle);

  /// True if the other triangle lies beyond one of the planes, but for corners at the ends of the
  /// edge that both have: then triangles_intersect() is false, and where no corner is shared the
  /// two are farther apart than `gap`. False may be either.
  /// @param gap [m]
  bool holds_off(const PlacedTriangle& other, double gap) const;

 private:
  /// Corners that lie beyond a plane do so by at least this share of the girth of both. What a
  /// corner on the plane leads to lies in a cone then, as far from what is not at its tip as this
  /// share of the triangle's height: far more than what counts as touching, or than rounding.
  static constexpr double clear_share = 1e-4;
  /// Triangles thinner than this, height over girth, have no fence.
  static constexpr double height_share = 1e-3;
  /// Nor is anything said of others that are so many times larger.
  static constexpr double size_ratio = 1e3;

  const PlacedTriangle& t_;
  Vec3<double> outward_[3];  ///< across the edge that starts at each corner
  double length_[3];
  Vec3<double> normal_;
  double normal_length_;
  bool usable_;
};

}  // namespace weft
