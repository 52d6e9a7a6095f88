#pragma once

#include "weft/scene.hpp"

/// Rotation vectors: the form in which motions interpolate rotations. transform_at() and apply()
/// themselves are declared in weft/scene.hpp.
namespace weft {

/// @return [rad] axis times angle of the placement's rotation
Vec3<double> rotation_vector(const Transform& transform);

/// Sets axis and angle from a rotation vector. The zero vector gives angle 0 about z.
/// @param vector [rad] axis times angle
void set_rotation_vector(Transform& transform, const Vec3<double>& vector);

}  // namespace weft
