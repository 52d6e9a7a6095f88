#include "host/geometry/ribbon.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "weft/shapes.hpp"

namespace weft::test {
namespace {

double area_of(const Mesh& mesh) {
  double sum = 0;
  for (const Tri& t : mesh.triangles) {
    const auto at = [&](int c) { return mesh.positions[static_cast<std::size_t>(t.v[c])]; };
    sum += 0.5 * length(cross(at(1) - at(0), at(2) - at(0)));
  }
  return sum;
}

TEST(Ribbon, StraightOneIsAGrid) {
  const Ribbon ribbon{0.2, {{-0.5, 0, 0}, {0.5, 0, 0}}, {0, 1, 0}};
  EXPECT_NEAR(ribbon_length(ribbon), 1, 1e-12);
  EXPECT_NEAR(ribbon_steepness(ribbon), 1, 1e-12);
  const Mesh mesh = make_ribbon(ribbon, {10, 2});
  const Mesh grid = make_grid({1, 0.2}, {10, 2}, Diagonals::alternating);
  ASSERT_EQ(mesh.positions.size(), grid.positions.size());
  for (std::size_t v = 0; v < grid.positions.size(); ++v)
    EXPECT_LT(length(mesh.positions[v] - grid.positions[v]), 1e-12) << v;
}

/// On edge around a circle: nothing is stretched, and the length is that of the circle.
TEST(Ribbon, OnEdgeItBendsWithoutStretching) {
  Ribbon ribbon{0.1, {}, {0, 0, 1}};
  constexpr int points = 24;
  for (int k = 0; k < points; ++k) {
    const double a = 2 * std::numbers::pi * k / points;
    ribbon.path.push_back({std::cos(a), std::sin(a), 0});
  }
  const double arc = 2 * std::numbers::pi * (points - 1) / points;
  EXPECT_NEAR(ribbon_length(ribbon), arc, 2e-3 * arc);
  const Mesh mesh = make_ribbon(ribbon, {200, 4});
  EXPECT_NEAR(area_of(mesh), 0.1 * arc, 2e-3 * 0.1 * arc);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto& x = mesh.positions[v];
    // The first and the last piece know nothing of what would follow: no better than chords.
    const std::size_t column = v % 201;
    const bool inner = column >= 10 && column <= 190;
    EXPECT_NEAR(std::hypot(x[0], x[1]), 1, inner ? 2e-4 : 1 - std::cos(std::numbers::pi / points));
    EXPECT_LE(std::abs(x[2]), 0.05 + 1e-12);
  }
  // Front on the side of path x across: outwards here.
  const Tri& t = mesh.triangles.front();
  const auto at = [&](int c) { return mesh.positions[static_cast<std::size_t>(t.v[c])]; };
  EXPECT_GT(dot(cross(at(1) - at(0), at(2) - at(0)), at(0)), 0);
}

TEST(Ribbon, HasNoSideAlongItsPath) {
  const Ribbon ribbon{0.1, {{0, 0, 0}, {0, 0, 1}}, {0, 0, 1}};
  EXPECT_LT(ribbon_steepness(ribbon), 1e-12);
}

}  // namespace
}  // namespace weft::test
