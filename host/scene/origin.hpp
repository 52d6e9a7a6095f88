#pragma once

#include "weft/scene.hpp"

namespace weft {

/// [m] World place that the scene's positions are relative to.
Vec3<double> origin_of(const Scene& scene);

/// Gives a scene in world positions an origin near its cloths, see local_origin(). A scene that has
/// an origin keeps it.
void choose_origin(Scene& scene);

/// Describes a scene from another origin. World positions stay the same.
void move_origin(Scene& scene, const Vec3<double>& origin);

/// Where a motion of world positions, such as that of a pin, takes a point.
/// @param x      [m] relative to `origin`
/// @param origin [m] world place
/// @return       [m] relative to `origin`. With a transform that only translates, or an origin on
///               its axis of rotation, the bits do not depend on the origin
Vec3<double> apply_in_world(const Transform& transform, const Vec3<double>& x,
                            const Vec3<double>& origin);

}  // namespace weft
