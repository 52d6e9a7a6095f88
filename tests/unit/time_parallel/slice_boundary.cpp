// How states on both sides of a seam are compared.
#include "host/time_parallel/slice_boundary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace weft::test {
namespace {

/// Two triangles that share an edge.
Scene hinge() {
  Scene scene;
  Cloth cloth;
  cloth.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  cloth.mesh.triangles = {{{0, 1, 2}}, {{1, 0, 3}}};
  scene.cloths.push_back(std::move(cloth));
  return scene;
}

/// The hinge with one triangle turned by an angle about the shared edge, moved, and moving. [rad]
Frame turned(double angle, Vec3<double> moved = {0, 0, 0}, Vec3<double> velocity = {0, 0, 0}) {
  Frame frame;
  frame.cloth_positions = {
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -std::cos(angle), std::sin(angle)}}};
  for (Vec3<double>& x : frame.cloth_positions[0]) x += moved;
  frame.cloth_velocities = {std::vector<Vec3<double>>(4, velocity)};
  return frame;
}

TEST(Seam, CurvatureErrorsAreThoseOfTheHinge) {
  const double pi = std::acos(-1.0);
  const Scene scene = hinge();
  const Frame flat = turned(0), half = turned(pi / 2), quarter = turned(pi / 4);
  EXPECT_NEAR(curvature_error(scene, half, flat), 1, 1e-12);
  EXPECT_NEAR(curvature_error(scene, half, quarter), 0.5, 1e-12);
  EXPECT_NEAR(curvature_error(scene, half, turned(-pi / 2)), 2, 1e-12) << "angles have a sign";
  EXPECT_EQ(curvature_error(scene, flat, flat), 0);
  EXPECT_EQ(curvature_error(scene, flat, half), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(dihedral_error(scene, flat, half), 0.5, 1e-12);
  // The sign of a turn is that of the mesh: pi - pi / 4 one way, pi + pi / 4 the other.
  const double one = dihedral_error(scene, quarter, flat);
  const double other = dihedral_error(scene, turned(-pi / 4), flat);
  EXPECT_NEAR(std::max(one, other), 1.0 / 3, 1e-12);
  EXPECT_NEAR(std::min(one, other), 1.0 / 5, 1e-12);
}

TEST(Seam, AnglesAreSummedEitherWay) {
  EXPECT_NEAR(angle_sum(hinge(), turned(0.7)), 0.7, 1e-12);
  EXPECT_NEAR(angle_sum(hinge(), turned(-0.7)), 0.7, 1e-12);
}

TEST(Seam, JumpsAreWhatMoves) {
  const Scene scene = hinge();
  const BoundaryJump jump = boundary_jump(scene, turned(0.3), turned(0.3, {0, 0.02, 0}, {0, 0, 3}));
  EXPECT_NEAR(jump.position, 0.02, 1e-15);
  EXPECT_NEAR(jump.position_rms, 0.02, 1e-15);
  EXPECT_NEAR(jump.velocity, 3, 1e-15);
  EXPECT_NEAR(jump.curvature, 0, 1e-12);
}

}  // namespace
}  // namespace weft::test
