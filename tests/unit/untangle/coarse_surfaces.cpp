// Coarser meshes of cloth: of one kind with the finer one, and followed by it.
#include "host/untangle/coarse_surfaces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/unit/untangle/tangles.hpp"

namespace weft::test {
namespace {

constexpr Index cells = 40;

IntersectingSurfaces sheet_over_ball(
    const std::function<bool(std::size_t, const Point&)>& held = nullptr) {
  return tangled({flat_grid(cells, 1, {0, 0, 0.3})}, {make_icosphere(0.2, 1)}, held);
}

double cloth_area(const IntersectingSurfaces& s) {
  double area = 0;
  for (Index t = 0; t < s.cloth_triangle_count; ++t) {
    const Tri& tri = s.triangles[static_cast<std::size_t>(t)];
    const auto x = [&](int j) { return s.points[static_cast<std::size_t>(tri.v[j])]; };
    area += length(cross(x(1) - x(0), x(2) - x(0))) / 2;
  }
  return area;
}

/// Largest difference of points from where `place` takes those at the start.
template <class Place>
double largest_miss(const std::vector<Point>& points, const std::vector<Point>& start,
                    std::size_t count, const Place& place) {
  double largest = 0;
  for (std::size_t v = 0; v < count; ++v)
    largest = std::max(largest, length(points[v] - place(start[v])));
  return largest;
}

TEST(CoarseSurfaces, AFlatSheetStaysItsOutline) {
  const IntersectingSurfaces fine = sheet_over_ball();
  CoarseSurfaces coarse(fine, fine.cloth_triangle_count / 4);
  const IntersectingSurfaces& c = coarse.surfaces();
  EXPECT_LE(c.cloth_triangle_count, fine.cloth_triangle_count / 4);
  EXPECT_GE(c.cloth_triangle_count, fine.cloth_triangle_count / 4 - 1);
  EXPECT_NEAR(cloth_area(c), 1, 1e-12);
  const SurfaceTopology topology(c.triangles, c.points.size());
  double mass = 0;
  for (std::size_t v = 0; v < c.points.size(); ++v)
    if (c.inverse_mass[v] > 0) mass += 1 / c.inverse_mass[v];
  EXPECT_NEAR(mass, (cells + 1.0) * (cells + 1.0), 1e-9);
  EXPECT_EQ(c.triangles.size() - static_cast<std::size_t>(c.cloth_triangle_count), 80u);
  EXPECT_EQ(c.solid, fine.solid);
  for (std::size_t e = 0; e < topology.edges.size(); ++e)
    EXPECT_LE(topology.edge_first[e + 1] - topology.edge_first[e], 2);
}

TEST(CoarseSurfaces, AffineMotionCarriesOver) {
  const IntersectingSurfaces fine = sheet_over_ball();
  const std::size_t cloth_points = (cells + 1) * (cells + 1);
  CoarseSurfaces coarse(fine, fine.cloth_triangle_count / 4);
  const auto place = [](const Point& x) {
    return Point{1.3 * x[0] + 0.1, x[1] - 0.2 * x[0], x[2] + 0.5 * x[0] - 0.7 * x[1]};
  };
  for (std::size_t v = 0; v < coarse.surfaces().points.size(); ++v) {
    Point& x = coarse.surfaces().points[v];
    if (coarse.surfaces().inverse_mass[v] > 0) x = place(x);
  }
  std::vector<Point> points = fine.points;
  coarse.carry_over(points);
  EXPECT_LT(largest_miss(points, fine.points, cloth_points, place), 1e-12);
  EXPECT_TRUE(std::equal(points.begin() + static_cast<std::ptrdiff_t>(cloth_points), points.end(),
                         fine.points.begin() + static_cast<std::ptrdiff_t>(cloth_points)));
}

TEST(CoarseSurfaces, SmoothMotionCarriesOverNearly) {
  const IntersectingSurfaces fine = sheet_over_ball();
  CoarseSurfaces coarse(fine, fine.cloth_triangle_count / 4);
  const auto place = [](const Point& x) {
    return Point{x[0], x[1], x[2] + 0.1 * std::cos(4 * x[0]) * std::cos(3 * x[1])};
  };
  for (Point& x : coarse.surfaces().points) x = place(x);
  std::vector<Point> points = fine.points;
  coarse.carry_over(points);
  // Edges of 0.07 m: the sag of a chord, 0.1 * 16 / 8 * 0.07^2 m, and that of a few more.
  EXPECT_LT(largest_miss(points, fine.points, (cells + 1) * (cells + 1), place), 3e-3);
}

TEST(CoarseSurfaces, WhatIsPinnedStaysToTheBit) {
  const auto held = [](std::size_t, const Point& x) { return x[0] < -0.3; };
  const IntersectingSurfaces fine = sheet_over_ball(held);
  CoarseSurfaces coarse(fine, fine.cloth_triangle_count / 4);
  std::size_t kept = 0;
  for (std::size_t v = 0; v < coarse.surfaces().points.size(); ++v) {
    if (coarse.surfaces().inverse_mass[v] > 0)
      coarse.surfaces().points[v] += Point{0.1, 0.2, 0.3};
    else
      ++kept;
  }
  std::vector<Point> points = fine.points;
  coarse.carry_over(points);
  std::size_t pinned = 0;
  for (std::size_t v = 0; v < points.size(); ++v) {
    EXPECT_EQ(points[v] == fine.points[v], fine.inverse_mass[v] == 0) << v;
    pinned += fine.inverse_mass[v] == 0;
  }
  EXPECT_LT(kept, pinned) << "those within have gone";
}

TEST(CoarseSurfaces, MarksThoseThatTakePart) {
  const IntersectingSurfaces fine = sheet_over_ball();
  CoarseSurfaces coarse(fine, fine.cloth_triangle_count / 4);
  std::vector<unsigned char> one(fine.points.size(), 0);
  one[20 * (cells + 1) + 20] = 1;
  const std::vector<unsigned char> marked = coarse.marked(one);
  ASSERT_EQ(marked.size(), coarse.surfaces().points.size());
  std::size_t count = 0;
  for (std::size_t v = 0; v < marked.size(); ++v) {
    if (marked[v] == 0) continue;
    ++count;
    EXPECT_LT(length(coarse.surfaces().points[v] - fine.points[20 * (cells + 1) + 20]), 0.2);
  }
  EXPECT_GE(count, 1u);
}

TEST(CoarseSurfaces, SharpFoldsKeepTheirVertices) {
  // A zig-zag of right angles whose folds lie on lines of vertices, four cells apart.
  const Mesh folded = bent_grid(cells, 1, [](const Point& x) {
    const double u = (x[0] + 0.5) * 10;
    const double part = u - 2 * std::floor(u / 2);
    return Point{0.7 * x[0], x[1], 0.07 * std::min(part, 2 - part)};
  });
  const IntersectingSurfaces fine = tangled({folded});
  CoarseSurfaces coarse(fine, fine.cloth_triangle_count / 4);
  EXPECT_LT(coarse.surfaces().cloth_triangle_count, fine.cloth_triangle_count / 2);
  EXPECT_NEAR(cloth_area(coarse.surfaces()) / cloth_area(fine), 1, 1e-12);
}

TEST(CoarseSurfaces, SheetsThatShareOneVertexKeepIt) {
  // Two triangles fans that meet in a point: nothing there is a surface.
  Mesh left = flat_grid(8, 1, {0, 0, 0});
  Mesh right = moved(left, {1, 1, 0});
  IntersectingSurfaces fine = tangled({left, right});
  const Index shared = 80, other = 81;  // the last corner of one, the first of the other
  ASSERT_TRUE(fine.points[80] == fine.points[81]);
  for (Tri& t : fine.triangles)
    for (Index& v : t.v)
      if (v == other) v = shared;
  CoarseSurfaces coarse(fine, fine.cloth_triangle_count / 4);
  const auto& points = coarse.surfaces().points;
  EXPECT_LT(coarse.surfaces().cloth_triangle_count, fine.cloth_triangle_count);
  EXPECT_TRUE(std::find(points.begin(), points.end(), fine.points[80]) != points.end());
  EXPECT_NEAR(cloth_area(coarse.surfaces()), 2, 1e-12);
}

}  // namespace
}  // namespace weft::test
