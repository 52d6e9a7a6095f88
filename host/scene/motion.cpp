#include "host/scene/motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/scene/key_slope.hpp"
#include "weft/core/assert.hpp"

namespace weft {
namespace {

/// One key as the vector that is interpolated: translation, rotation vector, scale. Rotation
/// vectors rather than quaternions, so that keys 0 and 360 degrees about one axis are a full turn.
using TransformParameters = Vec<double, 7>;

TransformParameters parameters_of(const Transform& transform) {
  const Vec3<double> rotation = rotation_vector(transform);
  const Vec3<double>& translate = transform.translate;
  return {translate[0], translate[1], translate[2],   rotation[0],
          rotation[1],  rotation[2],  transform.scale};
}

Transform transform_of(const TransformParameters& p) {
  Transform result;
  result.translate = {p[0], p[1], p[2]};
  set_rotation_vector(result, {p[3], p[4], p[5]});
  result.scale = p[6];
  return result;
}

/// Catmull-Rom slope at a key, limited per parameter [per second]; zero at the first and the last.
TransformParameters slope_at(const Motion& motion, std::size_t key) {
  if (key == 0 || key + 1 == motion.size()) return {};
  const Keyframe& before = motion[key - 1];
  const Keyframe& here = motion[key];
  const Keyframe& after = motion[key + 1];
  const TransformParameters left =
      (parameters_of(here.transform) - parameters_of(before.transform)) *
      (1.0 / (here.time - before.time));
  const TransformParameters right =
      (parameters_of(after.transform) - parameters_of(here.transform)) *
      (1.0 / (after.time - here.time));
  TransformParameters slope = (parameters_of(after.transform) - parameters_of(before.transform)) *
                              (1.0 / (after.time - before.time));
  for (int k = 0; k < 7; ++k) slope[k] = limited_slope(left[k], right[k], slope[k]);
  return slope;
}

}  // namespace

Vec3<double> rotation_vector(const Transform& transform) {
  return transform.rotation_axis * transform.rotation_angle;
}

void set_rotation_vector(Transform& transform, const Vec3<double>& vector) {
  const double angle = length(vector);
  transform.rotation_angle = angle;
  transform.rotation_axis = angle > 0 ? vector * (1.0 / angle) : Vec3<double>{0, 0, 1};
}

Transform transform_at(const Motion& motion, double time) {
  WEFT_ASSERT(motion.size() >= 2);
  if (!(time > motion.front().time)) return motion.front().transform;
  if (!(time < motion.back().time)) return motion.back().transform;

  const auto next = std::upper_bound(motion.begin(), motion.end(), time,
                                     [](double t, const Keyframe& key) { return t < key.time; });
  const auto i1 = static_cast<std::size_t>(next - motion.begin());
  const std::size_t i0 = i1 - 1;
  if (time == motion[i0].time) return motion[i0].transform;

  const double span = motion[i1].time - motion[i0].time;
  const double s = (time - motion[i0].time) / span;
  const double s2 = s * s;
  const double s3 = s2 * s;
  const TransformParameters p0 = parameters_of(motion[i0].transform);
  const TransformParameters p1 = parameters_of(motion[i1].transform);
  if (motion[i0].interpolation == Interpolation::linear) return transform_of(p0 + (p1 - p0) * s);
  // Written as p0 plus a share of the difference, so that equal keys stay exactly where they are.
  const TransformParameters p = p0 + (p1 - p0) * (3 * s2 - 2 * s3) +
                                slope_at(motion, i0) * ((s3 - 2 * s2 + s) * span) +
                                slope_at(motion, i1) * ((s3 - s2) * span);
  return transform_of(p);
}

Vec3<double> apply(const Transform& transform, const Vec3<double>& x) {
  const Vec3<double> scaled = x * transform.scale;
  if (transform.rotation_angle == 0) return scaled + transform.translate;
  // Rodrigues' rotation formula
  const Vec3<double>& axis = transform.rotation_axis;
  const double c = std::cos(transform.rotation_angle);
  const double s = std::sin(transform.rotation_angle);
  return scaled * c + cross(axis, scaled) * s + axis * (dot(axis, scaled) * (1 - c)) +
         transform.translate;
}

}  // namespace weft
