#pragma once

#include <vector>

#include "host/view/view_camera.hpp"
#include "host/view/view_surface.hpp"

namespace weft {

/// Depths of what a camera sees, in cells of some pixels.
class DepthPicture {
 public:
  explicit DepthPicture(const ViewCamera& camera);

  /// Adds a triangle, front or back.
  /// @param seen [3] [m] in the camera's frame
  void draw(const Vec3<double> seen[3]);

  /// Whether a point of the picture lies behind all that is seen in its cell and the eight around
  /// it, by more than half a percent of its depth. Where the background shows nothing is hidden.
  bool hides(const Vec3<double>& seen) const;

 private:
  struct Corner {
    double x, y;  ///< [cells]
    double near;  ///< [1/m] inverse depth, linear over the picture
  };
  Corner corner(const Vec3<double>& seen) const;
  void fill(const Corner& a, const Corner& b, const Corner& c);

  const ViewCamera& camera_;
  int columns_, rows_;
  double cells_;               ///< a pixel
  std::vector<double> depth_;  ///< [cells] [1/m] inverse, of the nearest; 0: nothing there
};

/// Triangles of cloth of which no part is seen, as obstacles or other cloth stand before them. They
/// are looked at in some of their points, close together; a triangle that is too near, or that
/// leaves the picture, is not hidden.
/// @return [triangles] 1 or 0
std::vector<unsigned char> hidden_triangles(const ViewCamera& camera, const ViewSurface& surface,
                                            const ViewPlaces& places);

}  // namespace weft
