#include "host/scene/seams/seam_pairing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "weft/core/at.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

Cloth strip(double width, Index cells, double y) {
  Cloth cloth;
  cloth.mesh = make_grid({width, 0.1}, {cells, 2}, Diagonals::alternating);
  for (Vec3<double>& x : cloth.mesh.positions) x[1] += y;
  return cloth;
}

/// Lower row of a strip, or its upper one.
std::vector<Index> row(Index cells, bool upper) {
  std::vector<Index> vertices;
  for (Index i = 0; i <= cells; ++i) vertices.push_back(upper ? 2 * (cells + 1) + i : i);
  return vertices;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const Tri& t : mesh.triangles) {
    const Vec2<double> a = mesh.material[at(t.v[1])] - mesh.material[at(t.v[0])];
    const Vec2<double> b = mesh.material[at(t.v[2])] - mesh.material[at(t.v[0])];
    const double twice = a[0] * b[1] - a[1] * b[0];
    EXPECT_GT(twice, 0);
    sum += twice / 2;
  }
  return sum;
}

TEST(SeamPairing, GivesEachVertexAPartnerAtItsShareOfTheLength) {
  for (const Index n : {1, 2, 7, 12, 30})
    for (const Index m : {1, 5, 12, 13, 31})
      for (const double ratio : {1.0, 1.5, 2.0}) {
        Cloth upper = strip(1, n, 0.2), lower = strip(ratio, m, 0);
        SewnMesh a(upper), b(lower);
        a.look_at(row(n, false));
        b.look_at(row(m, true));
        const auto pairs = pair_by_length(
            {&a, &b}, {*chain_of(a, row(n, false)), *chain_of(b, row(m, true))}, false);
        ASSERT_EQ(pairs[0].size(), pairs[1].size());
        for (const Index v : row(n, false))
          EXPECT_EQ(1, std::count(pairs[0].begin(), pairs[0].end(), v)) << n << " to " << m;
        for (const Index v : row(m, true))
          EXPECT_EQ(1, std::count(pairs[1].begin(), pairs[1].end(), v)) << n << " to " << m;
        // Vertices that nearly have a partner have that one.
        const double cell = 1.0 / std::max(n, m);
        double last = -1;
        for (std::size_t k = 0; k < pairs[0].size(); ++k) {
          const double x = upper.mesh.material[at(pairs[0][k])][0];
          const double y = lower.mesh.material[at(pairs[1][k])][0];
          EXPECT_NEAR(x, y / ratio, 0.5 * cell);
          EXPECT_GT(x - last, 0.2 * cell);
          last = x;
          if (k == 0) continue;
          EXPECT_TRUE(a.has_edge(pairs[0][k - 1], pairs[0][k]));
          EXPECT_TRUE(b.has_edge(pairs[1][k - 1], pairs[1][k]));
        }
        EXPECT_NEAR(area(upper.mesh), 0.1, 1e-12);
        EXPECT_NEAR(area(lower.mesh), 0.1 * ratio, 1e-12);
        if (n == m) {
          EXPECT_TRUE(a.added().empty() && b.added().empty());
        }
      }
}

/// Edges that others run along: both of their triangles are split, and share the new vertex.
TEST(SeamPairing, SplitsBothTrianglesOfAnInnerEdge) {
  Cloth cloth = strip(1, 4, 0);
  const std::vector<Index> middle{5, 6, 7, 8, 9};
  SewnMesh mesh(cloth);
  mesh.look_at(middle);
  const auto chain = chain_of(mesh, {9, 7, 5, 6, 8});
  ASSERT_TRUE(chain);
  EXPECT_EQ(chain->vertices, middle);
  const std::size_t before = cloth.mesh.triangles.size();
  const Index made = mesh.split(6, 7, 0.25);
  EXPECT_EQ(cloth.mesh.triangles.size(), before + 2);
  EXPECT_NEAR(cloth.mesh.material[at(made)][0], -0.1875, 1e-15);
  EXPECT_NEAR(area(cloth.mesh), 0.1, 1e-15);
  EXPECT_EQ(mesh.with_added({5, 6}), (std::vector<Index>{5, 6}));
  EXPECT_EQ(mesh.with_added({6, 7}), (std::vector<Index>{6, 7, made}));
}

TEST(SeamPairing, ChainsAreRowsOfNeighbours) {
  Cloth cloth = strip(1, 4, 0);
  SewnMesh mesh(cloth);
  const auto chain = [&](const std::vector<Index>& vertices) {
    mesh.look_at(vertices);
    return chain_of(mesh, vertices);
  };
  EXPECT_FALSE(chain({0}));
  EXPECT_FALSE(chain({0, 2}));
  EXPECT_FALSE(chain({0, 1, 3, 4}));
  EXPECT_FALSE(chain({1, 6, 11, 5, 7})) << "a cross";
  const auto around = chain({0, 1, 2, 3, 4, 9, 14, 13, 12, 11, 10, 5});
  ASSERT_TRUE(around);
  EXPECT_TRUE(around->closed);
  EXPECT_TRUE(in_order({3, 2, 1, 0, 5, 10, 11, 12, 13, 14, 9, 4, 3}, *around));
  EXPECT_FALSE(in_order({3, 1, 2, 0, 5, 10, 11, 12, 13, 14, 9, 4, 3}, *around));
}

/// Two rings that are turned against each other: the pairs are those that are nearest.
TEST(SeamPairing, ClosedChainsBeginWhereTheyAreNearest) {
  Cloth ring = {}, tube = {};
  ring.mesh = make_tube(0.2, 0.1, {12, 1});
  tube.mesh = make_tube(0.25, 0.1, {18, 1});
  for (Vec3<double>& x : tube.mesh.positions) {
    x[2] += 0.2;
    std::swap(x[0], x[1]);
    x[0] = -x[0];
  }
  std::vector<Index> upper, lower;
  for (Index i = 0; i < 12; ++i) upper.push_back(12 + i);
  for (Index i = 0; i < 18; ++i) lower.push_back(i);
  SewnMesh a(ring), b(tube);
  a.look_at(upper);
  b.look_at(lower);
  const auto pairs = pair_by_length({&a, &b}, {*chain_of(a, upper), *chain_of(b, lower)}, false);
  EXPECT_GE(pairs[0].size(), 18u);
  for (std::size_t k = 0; k < pairs[0].size(); ++k) {
    const Vec3<double>& x = ring.mesh.positions[at(pairs[0][k])];
    const Vec3<double>& y = tube.mesh.positions[at(pairs[1][k])];
    EXPECT_LT(std::hypot(x[0] - y[0], x[1] - y[1]), 0.09) << k;
  }
}

}  // namespace
}  // namespace weft
