#include "host/geometry/unfold.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "weft/shapes.hpp"

namespace weft {
namespace {

const std::vector<Tri>& corners_of(const Mesh& mesh) {
  return mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
}

void expect_isometric_and_unmirrored(const Mesh& mesh) {
  const auto& corners = corners_of(mesh);
  ASSERT_EQ(corners.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < corners.size(); ++t) {
    const auto x = [&](int k) {
      return mesh.positions[static_cast<std::size_t>(mesh.triangles[t].v[k % 3])];
    };
    const auto u = [&](int k) {
      return mesh.material[static_cast<std::size_t>(corners[t].v[k % 3])];
    };
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(length(u(k + 1) - u(k)), length(x(k + 1) - x(k)), 1e-9) << t;
    const Vec2<double> a = u(1) - u(0), b = u(2) - u(0);
    EXPECT_GT(a[0] * b[1] - a[1] * b[0], 0) << t;
  }
}

TEST(Unfold, ATubeIsCutOnceAndKeepsNeighbours) {
  Mesh tube = make_tube(0.3, 1, {16, 6});
  const std::size_t vertices = tube.positions.size();
  unfold(tube);
  expect_isometric_and_unmirrored(tube);
  // A tube that is cut from end to end has the vertices of the cut twice.
  EXPECT_GT(tube.material.size(), vertices);
  EXPECT_LE(tube.material.size(), vertices + 2 * 7);
}

TEST(Unfold, ASphereIsCutButEachTriangleKeepsItsShape) {
  Mesh sphere = make_icosphere(1, 2);
  unfold(sphere);
  expect_isometric_and_unmirrored(sphere);
  EXPECT_GT(sphere.material.size(), sphere.positions.size());
}

TEST(Unfold, FlatMeshesComeBackAndPiecesLieBesideEachOther) {
  Mesh mesh = make_grid({1, 1}, {3, 3});
  const Mesh other = make_grid({1, 1}, {2, 2});
  const auto first = static_cast<Index>(mesh.positions.size());
  for (const auto& x : other.positions) mesh.positions.push_back({x[0], x[1], x[2] + 1});
  for (const Tri& t : other.triangles)
    mesh.triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
  unfold(mesh);
  expect_isometric_and_unmirrored(mesh);
  EXPECT_TRUE(mesh.material_triangles.empty());
  double right = -1e9, left = 1e9;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (v < static_cast<std::size_t>(first))
      right = std::max(right, mesh.material[v][0]);
    else
      left = std::min(left, mesh.material[v][0]);
  EXPECT_GT(left, right);
}

}  // namespace
}  // namespace weft
