// Symmetric tensors of the plane, as sizes of edges are told by.
#include "host/geometry/tensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/adaptive/remesh_scenes.hpp"

namespace weft::test {
namespace {

void expect_near(const Mat2<double>& a, const Mat2<double>& b, double tolerance) {
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(a.e[k], b.e[k], tolerance) << "entry " << k;
}

TEST(RemeshTensor, EigenvaluesAndDirection) {
  const Mat2<double> m{{3, 1, 1, 3}};
  const Eigen2 e = eigen(m);
  EXPECT_NEAR(e.value[0], 4, 1e-15);
  EXPECT_NEAR(e.value[1], 2, 1e-15);
  EXPECT_NEAR(std::abs(e.axis[0]), std::sqrt(0.5), 1e-15);
  expect_near(compose(e), m, 1e-15);
}

TEST(RemeshTensor, OfEveryDirectionIsMadeOfItsEigenvalues) {
  for (int n = -180; n <= 180; ++n)
    for (const double ratio : {-1.0, 0.0, 1e-9, 0.5, 1 - 1e-9, 1.0}) {
      const double angle = n * std::numbers::pi / 180;
      const Vec2<double> along{std::cos(angle), std::sin(angle)}, across{-along[1], along[0]};
      const Mat2<double> m = 3 * outer(along, along) + 3 * ratio * outer(across, across);
      const Eigen2 e = eigen(m);
      EXPECT_NEAR(e.value[0], 3, 1e-14);
      EXPECT_NEAR(e.value[1], 3 * ratio, 1e-14);
      EXPECT_NEAR(length(e.axis), 1, 1e-15);
      expect_near(compose(e), m, 1e-14);
      if (ratio < 0.9) {
        EXPECT_NEAR(std::abs(dot(e.axis, along)), 1, 1e-14);
      }
    }
  for (const double off : {0.0, 1e-200, 1e-160, -1e-154, 1e-139}) {
    const Mat2<double> m{{5, off, off, 5}};
    EXPECT_NEAR(length(eigen(m).axis), 1, 1e-15);
    expect_near(compose(eigen(m)), m, 1e-14);
  }
}

TEST(RemeshTensor, SmallestAboveTwoThatCross) {
  // Disks of radius 2.5 about (1.5, 0) and (-1.5, 0): the one around both has radius 4.
  expect_near(tensor_above({diagonal(4, 1), diagonal(1, 4)}), diagonal(4, 4), 1e-14);
  expect_near(tensor_above({diagonal(4, 1)}), diagonal(4, 1), 1e-15);
  expect_near(tensor_above({diagonal(9, 9), diagonal(1, 4), {}}), diagonal(9, 9), 1e-14);
}

TEST(RemeshTensor, SmallestAboveThreeTouchesAll) {
  // Disks of radius 1 at the corners of a regular triangle on the unit circle: radius 2.
  Tensors tensors;
  for (int k = 0; k < 3; ++k) {
    const double angle = 2 * 3.14159265358979323846 * k / 3;
    const double x = std::cos(angle), y = std::sin(angle);
    tensors.push_back({{1 + x, y, y, 1 - x}});
  }
  expect_near(tensor_above(tensors), diagonal(2, 2), 1e-12);
}

TEST(RemeshTensor, CompressionOfAFlatSheet) {
  // Without curvature what is compressed by e asks for e / c^2, what is stretched for nothing.
  const double c = 0.005;
  expect_near(compression_tensor(diagonal(-0.02, 0.03), {}, c), diagonal(0.02 / (c * c), 0), 1e-9);
  // The root of a perpendicular curvature k adds or takes: 2 c^2 s = 0.02 + sqrt(0.02^2 - 4 c^2 k)
  // with k = 3 across, so that 4 c^2 k = 3e-4 and the root is 0.01; along the other axis k = 0.
  expect_near(compression_tensor(diagonal(-0.02, 0), diagonal(0, 3), c),
              diagonal(0.03 / (2 * c * c), 0), 1e-9);
  // e = 0.02 along x, wrinkled so much across that nothing is left to buckle.
  expect_near(compression_tensor(diagonal(-0.02, 0), diagonal(0, 1e4), c),
              diagonal((0.02 - std::sqrt(4 * c * c * 1e4 - 4e-4)) / (2 * c * c) > 0 ? 1 : 0, 0),
              1e-9);
}

TEST(RemeshTensor, ClampKeepsAspect) {
  expect_near(clamped(diagonal(1e6, 0), 1, 1e4, 0.04), diagonal(1e4, 400), 1e-9);
}

}  // namespace
}  // namespace weft::test
