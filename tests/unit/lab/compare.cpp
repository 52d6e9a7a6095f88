// What charts measure: distances between runs on the same and on different meshes.
#include "host/lab/chart/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "weft/shapes.hpp"

namespace weft::lab {
namespace {

Mesh grid(int cells) {
  return make_grid({1, 1}, {cells, cells}, Diagonals::alternating);
}

/// A quadratic surface over the material.
void lift(Mesh& mesh) {
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec2<double>& m = mesh.material[v];
    mesh.positions[v] = {m[0], m[1], m[0] * m[0] + 0.5 * m[0] * m[1]};
  }
}

TEST(ChartCompare, SameTrianglesCorrespondByNumber) {
  Mesh a = grid(4), b = grid(4);
  lift(a);
  b.material.clear();
  const Resampling map(a, b);
  ASSERT_TRUE(map.known());
  EXPECT_EQ(map.positions(a.positions), a.positions);
}

TEST(ChartCompare, OtherMeshesCorrespondByMaterial) {
  Mesh fine = grid(40), coarse = grid(7);
  lift(fine);
  lift(coarse);
  const Resampling map(fine, coarse);
  ASSERT_TRUE(map.known());
  // Linear interpolation of a quadratic on cells of 1/40: h^2 / 8 times its second derivative.
  const double bound = (1.0 / 40) * (1.0 / 40) / 8 * 4;
  const auto there = map.positions(fine.positions);
  for (std::size_t v = 0; v < there.size(); ++v) {
    EXPECT_NEAR(there[v][0], coarse.positions[v][0], 1e-12);
    EXPECT_NEAR(there[v][1], coarse.positions[v][1], 1e-12);
    EXPECT_NEAR(there[v][2], coarse.positions[v][2], bound);
  }
}

TEST(ChartCompare, PiecesDoNotMix) {
  // Two sheets over the same material, in this order in both meshes.
  const auto two = [](int cells) {
    Mesh mesh = grid(cells);
    const Mesh other = grid(cells + 1);
    const auto first = static_cast<Index>(mesh.positions.size());
    for (const auto& x : other.positions) mesh.positions.push_back({x[0], x[1], 5});
    mesh.material.insert(mesh.material.end(), other.material.begin(), other.material.end());
    for (const Tri& t : other.triangles)
      mesh.triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
    return mesh;
  };
  const Mesh a = two(9), b = two(4);
  const Resampling map(a, b);
  ASSERT_TRUE(map.known());
  EXPECT_LT(mean_distance(b.triangles, b.positions, map.positions(a.positions)), 1e-12);
  EXPECT_FALSE(Resampling(grid(9), b).known());  // one piece is not two
}

TEST(ChartCompare, DistanceOfAShiftIsTheShift) {
  const Mesh a = grid(5);
  auto moved = a.positions;
  for (auto& x : moved) x += Vec3<double>{0.3, 0, 0.4};
  EXPECT_NEAR(mean_distance(a.triangles, a.positions, moved), 0.5, 1e-14);
}

TEST(ChartCompare, DistanceWeighsByArea) {
  // One corner of a square of two triangles moves: it has a third of one or of both.
  Mesh a;
  a.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  a.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
  auto moved = a.positions;
  moved[1][2] = 1;
  EXPECT_NEAR(mean_distance(a.triangles, a.positions, moved), std::sqrt(1.0 / 6), 1e-14);
  moved = a.positions;
  moved[0][2] = 1;
  EXPECT_NEAR(mean_distance(a.triangles, a.positions, moved), std::sqrt(2.0 / 6), 1e-14);
}

TEST(ChartCompare, CurvatureErrorIsThatOfTheAngles) {
  Mesh a;
  a.positions = {{0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}};
  a.triangles = {{{0, 1, 2}}, {{1, 0, 3}}};
  const auto folded = [&](double angle) {
    auto x = a.positions;
    x[3] = {std::cos(angle), 0, std::sin(angle)};
    return x;
  };
  EXPECT_NEAR(curvature_error(a.triangles, folded(0.8), folded(0.6)), 0.25, 1e-12);
  EXPECT_NEAR(curvature_error(a.triangles, folded(0.8), folded(-0.8)), 2, 1e-12);
  EXPECT_EQ(curvature_error(a.triangles, a.positions, a.positions), 0);
  EXPECT_TRUE(std::isinf(curvature_error(a.triangles, a.positions, folded(0.1))));
}

TEST(ChartCompare, HausdorffLooksBothWays) {
  const Mesh a = grid(3);
  Mesh b = a;
  for (auto& x : b.positions) x[0] *= 2;  // half of b is beyond a
  EXPECT_NEAR(hausdorff_distance(a, b), 0.5, 1e-14);
  EXPECT_NEAR(hausdorff_distance(b, a), 0.5, 1e-14);
}

TEST(ChartCompare, StatisticsOfASquare) {
  const Statistics s = statistics(grid(64));
  EXPECT_NEAR(s.mean[0], 0, 1e-12);
  EXPECT_NEAR(s.spread[0], std::sqrt(1.0 / 12), 2e-4);
  EXPECT_EQ(s.spread[2], 0);
  Mesh moved = grid(64);
  for (auto& x : moved.positions) x[1] += 0.25;
  EXPECT_NEAR(difference(s, statistics(moved)), 0.25, 1e-12);
}

TEST(ChartCompare, MeansOverStartsHaveStandardErrors) {
  const auto at = [](double x) { return Statistics{{x, 0, 0}, {1, 1, 1 + x}}; };
  const MeanStatistics means = mean_statistics({at(1), at(2), at(3), at(6)});
  EXPECT_NEAR(means.mean.mean[0], 3, 1e-15);
  EXPECT_NEAR(means.mean.spread[2], 4, 1e-15);
  const double error = std::sqrt((4.0 + 1 + 0 + 9) / 3 / 4);
  EXPECT_NEAR(means.error.mean[0], error, 1e-15);
  EXPECT_EQ(means.error.spread[0], 0);
  const MeanStatistics one = mean_statistics({at(5)});
  EXPECT_EQ(one.error.mean[0], 0);
  EXPECT_NEAR(difference_error(means, one), error, 1e-15);
  EXPECT_NEAR(difference_error(means, means), std::sqrt(2.0) * error, 1e-15);
}

TEST(ChartCompare, ExtrapolationRemovesTheLeadingError) {
  for (const int order : {1, 2}) {
    const auto at = [&](double h) {
      return std::vector<Vec3<double>>{{1 + 3 * std::pow(h, order), 2 - std::pow(h, order), 0}};
    };
    const auto limit = extrapolated(at(0.2), at(0.1), order);
    EXPECT_NEAR(limit[0][0], 1, 1e-14);
    EXPECT_NEAR(limit[0][1], 2, 1e-14);
  }
}

}  // namespace
}  // namespace weft::lab
