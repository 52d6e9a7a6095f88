#pragma once

#include "weft/core/mat.hpp"
#include "weft/scene.hpp"

namespace weft {

/// What a camera sees, in its own frame: x to the right, y up, z along the view, |x| <= tan_x z and
/// |y| <= tan_y z. It begins at the eye and has no end.
struct Frustum {
  double tan_x = 1, tan_y = 1;  ///< > 0
};

/// Distance of a point, or of the nearest point of a triangle, from what is seen; 0: within. [m]
double frustum_distance(const Frustum& frustum, const Vec3<double>& point);
double frustum_distance(const Frustum& frustum, const Vec3<double> triangle[3]);

/// A camera at one instant.
class ViewCamera {
 public:
  /// @param width, height [pixels]
  /// @pre the key has passed validate_camera()
  ViewCamera(const CameraKey& key, int width, int height);

  /// In the camera's frame: to the right, up, along the view. [m]
  Vec3<double> seen(const Vec3<double>& x) const;
  /// Where a point appears: from the left, from the top. [pixels]
  /// @param seen with a depth > 0
  Vec2<double> pixel(const Vec3<double>& seen) const;

  const Frustum& frustum() const { return frustum_; }
  const Vec3<double>& eye() const { return eye_; }
  /// Depth from which on things can be drawn: a hundredth of the way to what it looks at. [m]
  double near() const { return near_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Vec3<double> eye_, right_, up_, forward_;
  Frustum frustum_;
  double near_;
  double scale_;  ///< [pixels] of a unit at depth 1
  int width_, height_;
};

/// Jacobian of the way from material space to the picture. [pixels/m]
/// @param pixels   [3] of the corners   @param material [3] [m]
Mat2<double> screen_jacobian(const Vec2<double> pixels[3], const Vec2<double> material[3]);

}  // namespace weft
