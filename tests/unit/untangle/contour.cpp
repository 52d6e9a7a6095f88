// Contours: what is found, how long it is, and how that changes as points move.
#include "host/untangle/contour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <set>

#include "tests/unit/untangle/tangles.hpp"

namespace weft::test {
namespace {

int count_of(const Contours& c, ContourKind kind) {
  int count = 0;
  for (Index i = 0; i < c.count; ++i) count += kind_of(c, i) == kind;
  return count;
}

TEST(Contour, NoneWhereNothingMeets) {
  const Contours c =
      contours_of(tangled({flat_grid(8, 1, {0, 0, 0}), flat_grid(7, 1, {0, 0, 0.01})}));
  EXPECT_TRUE(c.empty());
  EXPECT_EQ(c.count, 0);
  EXPECT_EQ(c.length(), 0);
}

TEST(Contour, SheetThroughBoxIsAsLongAsItsOutline) {
  const Contours c = contours_of(
      tangled({flat_grid(13, 1, {0.01, 0.02, 0.03})}, {make_box({0.4, 0.5, 0.6}, {3, 4, 5})}));
  EXPECT_EQ(c.count, 1);
  EXPECT_EQ(kind_of(c, 0), ContourKind::closed);
  EXPECT_NEAR(c.length(), 2 * (0.4 + 0.5), 1e-12);
  EXPECT_TRUE(c.touching.empty());
}

TEST(Contour, CrossingSheetsMeetInALineBetweenBorders) {
  const IntersectingSurfaces s =
      tangled({flat_grid(20, 1, {0, 0, 0}), tilted_grid(20, 0.7, {0, 0, 0})});
  const Contours c = contours_of(s);
  EXPECT_EQ(c.count, 1);
  EXPECT_EQ(kind_of(c, 0), ContourKind::boundary);
  // The second sheet is shifted along the line, so that each ends within the other.
  EXPECT_NEAR(c.length(), 1 - 0.007, 1e-12);
}

TEST(Contour, ConePokesAClosedContour) {
  const Contours c = contours_of(tangled({flat_grid(24, 1, {0, 0, 0}), cone()}));
  ASSERT_EQ(c.count, 1);
  EXPECT_EQ(kind_of(c, 0), ContourKind::closed);
  EXPECT_NEAR(c.length(), 2 * std::numbers::pi * 0.2, 0.01);  // a polygon, not quite the circle
  EXPECT_EQ(c.arcs.size(), c.piercings.size());
}

TEST(Contour, RidgeMakesTwoBetweenBorders) {
  const Contours c = contours_of(tangled({flat_grid(24, 1, {0, 0, 0}), ridge()}));
  EXPECT_EQ(c.count, 2);
  EXPECT_EQ(count_of(c, ContourKind::boundary), 2);
  EXPECT_NEAR(c.length(), 2 * 0.8, 1e-9);
}

TEST(Contour, EveryPiercingOnce) {
  const Contours c = contours_of(tangled({crumpled(3, 9, 0.15)}));
  ASSERT_GT(c.piercings.size(), 20u);
  std::set<std::pair<Index, Index>> seen;
  for (const Piercing& p : c.piercings) EXPECT_TRUE(seen.insert({p.edge, p.face}).second);
  EXPECT_TRUE(std::is_sorted(c.piercings.begin(), c.piercings.end(), [](auto& p, auto& q) {
    return std::pair(p.edge, p.face) < std::pair(q.edge, q.face);
  }));
}

TEST(Contour, TouchingSheetsAreFoundThoughNothingPierces) {
  const Contours c =
      contours_of(tangled({flat_grid(4, 1, {0, 0, 0}), flat_grid(5, 1, {0.1, 0, 0})}));
  EXPECT_TRUE(c.piercings.empty());
  EXPECT_FALSE(c.touching.empty());
  EXPECT_FALSE(c.empty());
}

TEST(Contour, OnlyCloth) {
  IntersectingSurfaces s =
      tangled({flat_grid(6, 1, {0, 0, 3}), flat_grid(6, 1, {0, 0, 4})},
              {make_icosphere(0.5, 1), moved(make_icosphere(0.5, 1), {0.4, 0, 0})});
  EXPECT_TRUE(contours_of(s).empty()) << "obstacles may run through each other";
  s = tangled({flat_grid(9, 1, {0, 0, 0}), cone()});
  s.self = false;
  EXPECT_TRUE(contours_of(s).empty()) << "and so may cloth that does not meet itself";
}

TEST(Contour, PassesOverPairsThatSleep) {
  const IntersectingSurfaces s = tangled({flat_grid(24, 1, {0, 0, 0}), cone()});
  const SurfaceTopology topology(s.triangles, s.points.size());
  std::vector<unsigned char> awake(s.points.size(), 0);
  ContourSearch search(s, topology);
  EXPECT_TRUE(search.find(awake).empty());
  std::fill(awake.begin() + 25 * 25, awake.end(), static_cast<unsigned char>(1));  // the cone's
  EXPECT_EQ(search.find(awake).piercings.size(), contours_of(s).piercings.size());
}

/// Again and again while points move, wake and fall asleep: what a search finds that knows of
/// nothing before.
TEST(Contour, SearchesAgainWhatHasChanged) {
  IntersectingSurfaces s = tangled({crumpled(3, 9, 0.15), flat_grid(9, 1, {0.01, 0.02, 0.03})},
                                   {make_box({0.4, 0.5, 0.6}, {3, 4, 5})});
  const SurfaceTopology topology(s.triangles, s.points.size());
  ContourSearch search(s, topology);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> way(-0.05, 0.05);
  std::vector<unsigned char> awake(s.points.size(), 1);
  std::size_t most = 0, least = s.points.size();
  for (int round = 0; round < 20; ++round) {
    const Contours found = search.find(awake);
    const Contours fresh = ContourSearch(s, topology).find(awake);
    ASSERT_EQ(found.piercings.size(), fresh.piercings.size()) << round;
    for (std::size_t k = 0; k < fresh.piercings.size(); ++k) {
      const Piercing &p = found.piercings[k], &q = fresh.piercings[k];
      EXPECT_TRUE(p.edge == q.edge && p.face == q.face && p.along == q.along &&
                  p.weights == q.weights && p.point == q.point)
          << round << ' ' << k;
    }
    EXPECT_EQ(found.touching, fresh.touching) << round;
    EXPECT_EQ(found.number, fresh.number) << round;
    most = std::max(most, fresh.piercings.size());
    least = std::min(least, fresh.piercings.size());
    if (round % 5 == 4) std::fill(awake.begin(), awake.end(), static_cast<unsigned char>(0));
    for (std::size_t v = 0; v < s.points.size(); ++v) {
      if (random() % 8 != 0) continue;
      awake[v] = random() % 3 != 0;
      if (s.inverse_mass[v] == 0 || awake[v] == 0 || random() % 2 == 0) continue;
      s.points[v] += Point{way(random), way(random), way(random)};
    }
  }
  EXPECT_GT(most, 100u);
  EXPECT_LT(least, most / 2);
}

/// The gradient against central differences of the length, point by point.
void expect_gradient(IntersectingSurfaces s) {
  const SurfaceTopology topology(s.triangles, s.points.size());
  const Contours c = contours_of(s);
  ASSERT_FALSE(c.piercings.empty());
  const std::vector<Point> gradient = contour_gradient(s, topology, c);
  const double h = 1e-7;
  int tried = 0;
  double largest = 0;
  for (std::size_t v = 0; v < s.points.size(); ++v) {
    if (gradient[v] == Point{0, 0, 0}) continue;
    const Point x = s.points[v];
    for (int k = 0; k < 3; ++k) {
      double length[2];
      bool same = true;
      for (int side = 0; side < 2; ++side) {
        s.points[v] = x;
        s.points[v][k] += side == 0 ? -h : h;
        const Contours moved = contours_of(s);
        // The length has a kink where a contour passes over a vertex.
        same = same && moved.piercings.size() == c.piercings.size();
        for (std::size_t i = 0; same && i < c.piercings.size(); ++i)
          same = moved.piercings[i].edge == c.piercings[i].edge &&
                 moved.piercings[i].face == c.piercings[i].face;
        length[side] = moved.length();
      }
      s.points[v] = x;
      if (!same) continue;
      ++tried;
      largest = std::max(largest, std::fabs(gradient[v][k]));
      // Rounding of the length, 1e-16 m over h, and its curvature, which is large where an edge is
      // nearly in the plane of the face, as is the gradient then.
      EXPECT_NEAR((length[1] - length[0]) / (2 * h), gradient[v][k],
                  1e-6 * (1 + std::fabs(gradient[v][k])))
          << "point " << v << " along " << k;
    }
  }
  EXPECT_GT(tried, 40);
  EXPECT_GT(largest, 0.1);
}

TEST(ContourGradient, OfAClosedContour) {
  expect_gradient(tangled({flat_grid(12, 1, {0, 0, 0}), cone()}));
}

TEST(ContourGradient, OfOneBetweenBorders) {
  expect_gradient(tangled({flat_grid(9, 1, {0, 0, 0}), beside()}));
}

TEST(ContourGradient, OfOneOnAnObstacle) {
  expect_gradient(tangled({tilted_grid(10, 0.3, {0, 0, 0})}, {make_icosphere(0.3, 2)}));
}

TEST(ContourGradient, OfSelfIntersections) {
  // Some of these end at a corner that both triangles have.
  const IntersectingSurfaces s = tangled({crumpled(3, 9, 0.15)});
  const Contours c = contours_of(s);
  EXPECT_TRUE(std::any_of(c.arcs.begin(), c.arcs.end(), [](auto& a) { return a.corner >= 0; }));
  expect_gradient(s);
}

TEST(ContourGradient, DownhillIsShorter) {
  IntersectingSurfaces s = tangled({flat_grid(24, 1, {0, 0, 0}), cone()});
  const SurfaceTopology topology(s.triangles, s.points.size());
  const Contours c = contours_of(s);
  const std::vector<Point> gradient = contour_gradient(s, topology, c);
  double slope = 0;
  for (std::size_t v = 0; v < s.points.size(); ++v) {
    s.points[v] -= gradient[v] * 1e-5;
    slope += length_sq(gradient[v]);
  }
  EXPECT_NEAR((c.length() - contours_of(s).length()) / (1e-5 * slope), 1, 0.01);
}

}  // namespace
}  // namespace weft::test
