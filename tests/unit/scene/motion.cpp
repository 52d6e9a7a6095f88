#include "host/scene/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace weft {
namespace {

constexpr double pi = std::numbers::pi;

Keyframe key(double time, const Vec3<double>& translate, const Vec3<double>& axis = {0, 0, 1},
             double angle = 0, double scale = 1) {
  return {time, {translate, axis, angle, scale}};
}

Motion three_keys() {
  return {key(1, {0, 0, 0}), key(2, {1, 2, -1}, {0, 1, 0}, 0.5, 1.5),
          key(4, {0, 3, 1}, {1, 0, 0}, 1.0, 2)};
}

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double tolerance) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "component " << k;
}

/// Velocity of a carried point by central differences.
Vec3<double> velocity(const Motion& motion, double time, double h) {
  const Vec3<double> x{0.3, -0.2, 0.7};
  return (apply(transform_at(motion, time + h), x) - apply(transform_at(motion, time - h), x)) *
         (0.5 / h);
}

TEST(Motion, HitsEveryKey) {
  const Motion motion = three_keys();
  const Vec3<double> x{0.3, -0.2, 0.7};
  for (const Keyframe& k : motion) {
    const Transform at = transform_at(motion, k.time);
    expect_near(apply(at, x), apply(k.transform, x), 0);
    // The curve arrives there too, not only the shortcut for a key's own time.
    expect_near(apply(transform_at(motion, k.time + 1e-9), x), apply(k.transform, x), 1e-8);
    expect_near(apply(transform_at(motion, k.time - 1e-9), x), apply(k.transform, x), 1e-8);
  }
}

TEST(Motion, HoldsOutside) {
  const Motion motion = three_keys();
  expect_near(transform_at(motion, -5).translate, motion.front().transform.translate, 0);
  expect_near(transform_at(motion, 99).translate, motion.back().transform.translate, 0);
  EXPECT_EQ(transform_at(motion, 99).scale, 2);
  EXPECT_EQ(transform_at(motion, 99).rotation_angle, 1);
}

TEST(Motion, StartsAndEndsAtRest) {
  const Motion motion = three_keys();
  // One-sided, inside the interval: a slope s would give s * h.
  const double h = 1e-5;
  const Vec3<double> x{0.3, -0.2, 0.7};
  const auto at = [&](double time) { return apply(transform_at(motion, time), x); };
  EXPECT_LT(length(at(1 + h) - at(1)), 1e-8);
  EXPECT_LT(length(at(4) - at(4 - h)), 1e-8);
}

TEST(Motion, InnerSlopeIsCatmullRom) {
  const Motion motion{key(0, {0, 0, 0}), key(1, {2, 0, 0}), key(4, {5, 0, 0})};
  const double h = 1e-5;
  const double before =
      (transform_at(motion, 1).translate[0] - transform_at(motion, 1 - h).translate[0]) / h;
  const double after =
      (transform_at(motion, 1 + h).translate[0] - transform_at(motion, 1).translate[0]) / h;
  EXPECT_NEAR(before, 5.0 / 4.0, 1e-3);
  EXPECT_NEAR(after, 5.0 / 4.0, 1e-3);
}

TEST(Motion, LinearToTheNextKeyOnly) {
  Motion motion = three_keys();
  motion[0].interpolation = Interpolation::linear;
  for (const double share : {0.25, 0.5, 0.75}) {
    const Transform at = transform_at(motion, 1 + share);
    expect_near(at.translate, Vec3<double>{1, 2, -1} * share, 1e-15);
    EXPECT_NEAR(at.rotation_angle, 0.5 * share, 1e-15);
    EXPECT_NEAR(at.scale, 1 + 0.5 * share, 1e-15);
    // The way to the third key is what it was.
    expect_near(transform_at(motion, 2 + 2 * share).translate,
                transform_at(three_keys(), 2 + 2 * share).translate, 0);
  }
}

TEST(Motion, NeverLeavesTheIntervalBetweenTwoKeys) {
  // Held between two equal keys; turned round at a key; slow after fast.
  const Motion motion{key(0, {0.05, 0, 0}), key(0.2, {0.01, 0.3, 1}), key(0.3, {0.01, 0, 1.001}),
                      key(0.9, {0.01, 0.4, 9}, {1, 0, 0}, 2, 3),
                      key(1, {0.02, 0.4, 9.001}, {1, 0, 0}, 2, 3)};
  const auto inside = [](double a, double b, double x) {
    return x >= std::min(a, b) - 1e-15 && x <= std::max(a, b) + 1e-15;
  };
  for (std::size_t k = 0; k + 1 < motion.size(); ++k)
    for (int i = 0; i <= 50; ++i) {
      const double time = motion[k].time + i / 50.0 * (motion[k + 1].time - motion[k].time);
      const Transform& a = motion[k].transform;
      const Transform& b = motion[k + 1].transform;
      const Transform at = transform_at(motion, time);
      for (int c = 0; c < 3; ++c)
        EXPECT_TRUE(inside(a.translate[c], b.translate[c], at.translate[c])) << time << ' ' << c;
      EXPECT_TRUE(inside(a.scale, b.scale, at.scale)) << time;
      EXPECT_TRUE(inside(a.rotation_angle, b.rotation_angle, at.rotation_angle)) << time;
    }
}

TEST(Motion, VelocityIsContinuousAtKeys) {
  const Motion motion = three_keys();
  expect_near(velocity(motion, 2 - 1e-6, 1e-7), velocity(motion, 2 + 1e-6, 1e-7), 1e-4);
}

TEST(Motion, TwoKeysFollowSmoothstep) {
  const Motion motion{key(0, {0, 0, 0}), key(2, {1, 0, 0})};
  EXPECT_DOUBLE_EQ(transform_at(motion, 1).translate[0], 0.5);
  EXPECT_DOUBLE_EQ(transform_at(motion, 0.5).translate[0], 3.0 / 16 - 2.0 / 64);
}

TEST(Motion, StaysRigid) {
  const Motion motion{key(0, {0, 0, 0}, {0, 0, 1}, 0.4), key(1, {0, 0, 0}, {0, 1, 0}, 2.5),
                      key(2, {0, 0, 0}, {0.6, 0.8, 0}, -1)};
  const Vec3<double> a{1, 0, 0};
  const Vec3<double> b{0, 2, 0.5};
  for (double t = 0; t <= 2; t += 0.01) {
    const Transform at = transform_at(motion, t);
    EXPECT_NEAR(length(at.rotation_axis), 1, 1e-14);
    EXPECT_NEAR(length(apply(at, a) - apply(at, b)), length(a - b), 1e-14);
    const Vec3<double> c = apply(at, {0, 0, 1});
    EXPECT_NEAR(dot(cross(apply(at, {1, 0, 0}), apply(at, {0, 1, 0})), c), 1, 1e-13);
  }
}

TEST(Motion, FullTurnTurns) {
  const Motion motion{key(0, {0, 0, 0}), key(1, {0, 0, 0}, {0, 0, 1}, 2 * pi)};
  expect_near(apply(transform_at(motion, 0.5), {1, 0, 0}), {-1, 0, 0}, 1e-14);
}

TEST(Motion, EqualKeysStandExactlyStill) {
  const Motion motion{key(0, {0.1, 0.2, 0.3}, {0, 0, 1}, 0, 0.7),
                      key(1, {0.1, 0.2, 0.3}, {0, 0, 1}, 0, 0.7)};
  expect_near(transform_at(motion, 0.37).translate, {0.1, 0.2, 0.3}, 0);
  EXPECT_EQ(transform_at(motion, 0.37).scale, 0.7);
}

TEST(Apply, ScalesThenRotatesThenTranslates) {
  const Transform transform{{10, 0, 0}, {0, 0, 1}, pi / 2, 2};
  expect_near(apply(transform, {1, 0, 3}), {10, 2, 6}, 1e-14);
  expect_near(apply({{0, 0, 0}, {1, 0, 0}, pi / 2, 1}, {0, 1, 0}), {0, 0, 1}, 1e-15);
}

TEST(RotationVector, RoundTrips) {
  Transform transform;
  set_rotation_vector(transform, {0.3, -0.4, 1.2});
  expect_near(rotation_vector(transform), {0.3, -0.4, 1.2}, 1e-15);
  set_rotation_vector(transform, {0, 0, 0});
  EXPECT_EQ(transform.rotation_angle, 0);
  EXPECT_EQ(length(transform.rotation_axis), 1);
}

}  // namespace
}  // namespace weft
