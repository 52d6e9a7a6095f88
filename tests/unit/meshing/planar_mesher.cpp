#include "host/meshing/planar_mesher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "host/meshing/constrained_delaunay.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

using Outline = std::vector<Vec2<double>>;

/// A polygon with its sides cut into parts of about `edge`.
Outline cut(const Outline& corners, double edge) {
  Outline outline;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec2<double> a = corners[k], b = corners[(k + 1) % corners.size()];
    const int parts = std::max(1, static_cast<int>(std::lround(length(b - a) / edge)));
    for (int i = 0; i < parts; ++i) outline.push_back(a + (b - a) * (1.0 * i / parts));
  }
  return outline;
}

Outline circle(double radius, double edge) {
  const int n = static_cast<int>(std::lround(2 * std::numbers::pi * radius / edge));
  Outline outline;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return outline;
}

struct Case {
  const char* name;
  Outline outline;
  double edge;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

/// A skirt panel with two darts, whose tips are sharp notches.
const Outline darted{{0, 0},      {0.5, 0},    {0.47, 0.6},   {0.37, 0.6}, {0.355, 0.42},
                     {0.34, 0.6}, {0.16, 0.6}, {0.145, 0.42}, {0.13, 0.6}, {0.03, 0.6}};

class PlanarMesher : public testing::TestWithParam<Case> {};

/// The mesh covers the outline once: its sides are those of the outline, each inner edge has two
/// triangles, none is turned over, and the areas add up.
TEST_P(PlanarMesher, FillsItsOutline) {
  const Outline& outline = GetParam().outline;
  ASSERT_FALSE(find_crossing(outline));
  const PlanarMesh mesh = mesh_outline(outline, GetParam().edge);
  ASSERT_TRUE(std::equal(outline.begin(), outline.end(), mesh.points.begin()));
  double area = 0;
  std::map<std::array<Index, 2>, int> uses;
  std::vector<bool> used(mesh.points.size(), false);
  for (const Tri& t : mesh.triangles) {
    const Vec2<double> a = mesh.points[at(t.v[0])];
    const Vec2<double> b = mesh.points[at(t.v[1])] - a, c = mesh.points[at(t.v[2])] - a;
    const double twice = b[0] * c[1] - b[1] * c[0];
    EXPECT_GT(twice, 0);
    area += twice / 2;
    for (int k = 0; k < 3; ++k) {
      ++uses[{t.v[k], t.v[(k + 1) % 3]}];
      used[at(t.v[k])] = true;
    }
  }
  EXPECT_NEAR(area, signed_area(outline), 1e-9 * area);
  const auto n = static_cast<Index>(outline.size());
  for (const auto& [edge, count] : uses) {
    EXPECT_EQ(count, 1);
    const bool side = edge[0] < n && edge[1] == (edge[0] + 1) % n;
    EXPECT_EQ(uses.contains({edge[1], edge[0]}), !side) << edge[0] << " to " << edge[1];
  }
  for (Index k = 0; k < n; ++k) EXPECT_TRUE(uses.contains({k, (k + 1) % n})) << k;
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
}

/// Away from the corners of the outline that are sharper themselves.
TEST_P(PlanarMesher, HasNoSmallAngles) {
  const Outline& outline = GetParam().outline;
  const PlanarMesh mesh = mesh_outline(outline, GetParam().edge);
  const std::size_t n = outline.size();
  const auto sharp = [&](Index v) {
    if (at(v) >= n) return false;
    const Vec2<double> p = outline[(at(v) + 1) % n] - outline[at(v)];
    const Vec2<double> q = outline[(at(v) + n - 1) % n] - outline[at(v)];
    const double cosine = dot(p, q) / (length(p) * length(q));
    return cosine > std::cos(40 * std::numbers::pi / 180);
  };
  double least = 180, mean = 0;
  for (const Tri& t : mesh.triangles) {
    const double angle =
        least_angle(mesh.points[at(t.v[0])], mesh.points[at(t.v[1])], mesh.points[at(t.v[2])]);
    mean += angle / static_cast<double>(mesh.triangles.size());
    if (std::none_of(t.v, t.v + 3, sharp)) least = std::min(least, angle);
  }
  EXPECT_GE(least, 20);
  EXPECT_GE(mean, 45);
}

TEST_P(PlanarMesher, IsAPureFunction) {
  const PlanarMesh a = mesh_outline(GetParam().outline, GetParam().edge);
  const PlanarMesh b = mesh_outline(GetParam().outline, GetParam().edge);
  EXPECT_TRUE(a.points == b.points);
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  for (std::size_t t = 0; t < a.triangles.size(); ++t)
    EXPECT_TRUE(std::equal(a.triangles[t].v, a.triangles[t].v + 3, b.triangles[t].v));
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, PlanarMesher,
    testing::Values(Case{"Square", cut({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 0.05), 0.05},
                    Case{"Fine", cut({{0, 0}, {1, 0}, {1, 0.7}, {0, 1}}, 0.01), 0.01},
                    Case{"Darted", cut(darted, 0.02), 0.02},
                    Case{"DartedFine", cut(darted, 0.007), 0.007},
                    Case{"DartedCoarse", cut(darted, 0.05), 0.05},
                    Case{"Strip", cut({{0, 0}, {0.8, 0}, {0.8, 0.03}, {0, 0.03}}, 0.02), 0.02},
                    Case{"Circle", circle(0.3, 0.02), 0.02},
                    Case{"FarAway", cut({{80, 90}, {80.4, 90}, {80.3, 90.5}}, 0.02), 0.02},
                    Case{"Gathered", cut({{0, 0}, {0.6, 0}, {0.6, 0.4}, {0, 0.4}}, 0.034), 0.02},
                    Case{"Dense", cut({{0, 0}, {0.3, 0}, {0.3, 0.4}, {0, 0.4}}, 0.0116), 0.02},
                    Case{"Comb",
                         cut({{0, 0},
                              {0.5, 0},
                              {0.5, 0.3},
                              {0.4, 0.3},
                              {0.4, 0.05},
                              {0.3, 0.05},
                              {0.3, 0.3},
                              {0.2, 0.3},
                              {0.2, 0.05},
                              {0, 0.3}},
                             0.02),
                         0.02}),
    [](const testing::TestParamInfo<Case>& c) { return std::string(c.param.name); });

TEST(FindCrossing, FindsSidesThatCrossOrTouch) {
  EXPECT_FALSE(find_crossing({{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  EXPECT_FALSE(find_crossing({{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_EQ(find_crossing({{0, 0}, {1, 1}, {1, 0}, {0, 1}}), (OutlineCrossing{0, 2}));
  // a corner on a side
  EXPECT_EQ(find_crossing({{0, 0}, {2, 0}, {2, 1}, {1, 0}, {0, 1}}), (OutlineCrossing{0, 2}));
  // a side that runs back along the one before
  EXPECT_EQ(find_crossing({{0, 0}, {2, 0}, {1, 0}, {1, 1}}), (OutlineCrossing{0, 1}));
  // two corners at one place
  EXPECT_TRUE(find_crossing({{0, 0}, {1, 0}, {1, 1}, {0.5, 0.5}, {0, 1}, {0.5, 0.5}}));
  EXPECT_TRUE(find_crossing({{0, 0}, {0, 0}, {1, 0}, {1, 1}}));
}

TEST(FindCrossing, TellsMirroredOutlinesAlike) {
  Outline outline = cut(darted, 0.01);
  EXPECT_FALSE(find_crossing(outline));
  outline[30] = outline[75];
  EXPECT_TRUE(find_crossing(outline));
}

/// Lines and circles through corners of a grid: signs of zero come out as zero.
TEST(GridPoint, IsExact) {
  const std::int64_t l = grid_limit;
  EXPECT_EQ(orientation({-l, -l}, {0, 0}, {l, l}), 0);
  EXPECT_GT(orientation({-l, -l}, {0, 0}, {l - 1, l}), 0);
  EXPECT_FALSE(in_circle({-l, -l}, {l, -l}, {l, l}, {-l, l}));
  EXPECT_TRUE(in_circle({-l, -l}, {l, -l}, {l, l}, {-l + 1, l}));
  EXPECT_FALSE(in_circle({-l + 1, -l}, {l, -l}, {l, l}, {-l, l}));
}

/// Points on one line, on one circle and twice.
TEST(ConstrainedDelaunay, TakesPointsInAnyPosition) {
  ConstrainedDelaunay triangulation;
  std::vector<Index> numbers;
  for (std::int64_t j = 0; j < 12; ++j)
    for (std::int64_t i = 0; i < 12; ++i) numbers.push_back(triangulation.insert({i * 4, j * 4}));
  EXPECT_EQ(triangulation.insert({8, 4}), numbers[14]);
  for (const auto& face : triangulation.faces()) {
    const GridPoint &a = triangulation.point(face.v[0]), &b = triangulation.point(face.v[1]),
                    &c = triangulation.point(face.v[2]);
    EXPECT_GT(orientation(a, b, c), 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index other = face.next[k];
      if (other < 0) continue;
      for (const Index v : triangulation.faces()[at(other)].v)
        EXPECT_FALSE(in_circle(a, b, c, triangulation.point(v)));
    }
  }
  // from a corner to a place a knight's move off the diagonal, across a row of squares
  EXPECT_TRUE(triangulation.fix_edge(numbers[0], numbers[12 * 11 + 10]));
  EXPECT_FALSE(triangulation.fix_edge(numbers[0], numbers[2])) << "over a point";
  EXPECT_FALSE(triangulation.fix_edge(numbers[12 * 5], numbers[12 * 4 + 11]))
      << "across a given edge";
}

}  // namespace
}  // namespace weft
