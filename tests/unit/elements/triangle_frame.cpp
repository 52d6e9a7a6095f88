#include "weft/elements/triangle_frame.hpp"

#include <gtest/gtest.h>

#include "tests/unit/elements/configurations.hpp"

namespace weft {
namespace {

using test::Long;
using test::Random;

template <class T>
struct Placed {
  Vec3<T> x[3];
  Mat2<T> inv_rest;
};

/// A random triangle, stretched and moved at random; slivers have a height of 1e-5.
Placed<double> placed(Random& random, bool sliver) {
  Placed<double> p{};
  const double width = random.uniform(0.5, 1.5);
  const double height = random.uniform(0.5, 1.5);
  p.inv_rest = {{1 / width, -random.uniform(-1, 1), 0, 1 / height}};
  for (;;) {
    for (auto& x : p.x) x = random.point(1);
    if (sliver) p.x[2] = p.x[0] + (p.x[1] - p.x[0]) * random.uniform(0, 1) + random.point(1e-5);
    if (length(cross(p.x[1] - p.x[0], p.x[2] - p.x[0])) > (sliver ? 1e-6 : 0.1)) return p;
  }
}

template <class T>
Placed<T> cast(const Placed<double>& p) {
  Placed<T> out{};
  for (int i = 0; i < 3; ++i) out.x[i] = vec_cast<T>(p.x[i]);
  for (int i = 0; i < 4; ++i) out.inv_rest.e[i] = static_cast<T>(p.inv_rest.e[i]);
  return out;
}

TEST(TriangleFrame, is_the_rotation_of_the_polar_decomposition) {
  Random random(4);
  for (int n = 0; n < 200; ++n) {
    const Placed<double> p = placed(random, false);
    const auto f = triangle_frame(p.x, p.inv_rest);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(i == j, dot(f.axis[i], f.axis[j]), 1e-12);
    EXPECT_NEAR(1, dot(cross(f.axis[0], f.axis[1]), f.axis[2]), 1e-12);
    // F = axes S with S symmetric, positive definite.
    const double s[2][2] = {{f.s00, f.s01}, {f.s01, f.s11}};
    EXPECT_GT(f.s00 * f.s11 - f.s01 * f.s01, 0);
    EXPECT_GT(f.s00 + f.s11, 0);
    for (int k = 0; k < 2; ++k) {
      const Vec3<double> column =
          (p.x[1] - p.x[0]) * p.inv_rest(0, k) + (p.x[2] - p.x[0]) * p.inv_rest(1, k);
      EXPECT_LT(length(column - f.axis[0] * s[0][k] - f.axis[1] * s[1][k]), 1e-12);
    }
  }
}

TEST(TriangleFrame, gradient_is_how_it_turns) {
  Random random(5);
  for (int n = 0; n < 200; ++n) {
    const bool sliver = n % 2 == 1;
    const Placed<double> p = placed(random, sliver);
    const Vec3<double> torque = random.point(1);
    const auto f = triangle_frame(p.x, p.inv_rest);
    Vec3<double> g[3];
    triangle_frame_gradient(f, p.inv_rest, torque, g);
    const double size = length(g[0]) + length(g[1]) + length(g[2]);
    EXPECT_LT(length(g[0] + g[1] + g[2]), 1e-14 * size);
    const auto precise = cast<Long>(p);
    const Long step = sliver ? 1e-10L : 1e-6L;
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 3; ++c) {
        TriangleFrame<Long> side[2];
        for (const int k : {0, 1}) {
          Placed<Long> q = precise;
          q.x[i][c] += k == 0 ? -step : step;
          side[k] = triangle_frame(q.x, q.inv_rest);
        }
        // A rotation by w moves each axis by w x axis; the sum of axis x (w x axis) is 2 w.
        Vec3<Long> twice{};
        for (int a = 0; a < 3; ++a)
          twice += cross(vec_cast<Long>(f.axis[a]), side[1].axis[a] - side[0].axis[a]);
        const Long rate = dot(twice, vec_cast<Long>(torque)) / (4 * step);
        EXPECT_NEAR(static_cast<double>(rate), g[i][c], 1e-7 * size) << n;
      }
  }
}

TEST(TriangleFrame, triangles_without_area_have_none) {
  Vec3<double> x[3] = {{0, 0, 0}, {1, 2, 3}, {0.5, 1, 1.5}};
  for (const bool point : {false, true}) {
    if (point) x[1] = x[2] = x[0];
    const auto f = triangle_frame(x, Mat2<double>::identity());
    Vec3<double> g[3];
    triangle_frame_gradient(f, Mat2<double>::identity(), {1, 2, 3}, g);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(0, length(f.axis[i]));
      EXPECT_EQ(0, length(g[i]));
    }
  }
}

}  // namespace
}  // namespace weft
