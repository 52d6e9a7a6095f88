#include "host/geometry/culling_planes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "host/base/random.hpp"
#include "weft/elements/distance.hpp"

/// What a fence says against the exact tests, and that it says something where surfaces are smooth.
namespace weft {
namespace {

PlacedTriangle placed(const Tri& places, const Corners& x) {
  double girth = 0;
  for (int c = 0; c < 3; ++c)
    girth += std::max({x[0][c], x[1][c], x[2][c]}) - std::min({x[0][c], x[1][c], x[2][c]});
  return {places, x, girth};
}

double distance_between(const Corners& s, const Corners& t) {
  double least_sq = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3<double> a[4] = {s[i], t[0], t[1], t[2]};
    const Vec3<double> b[4] = {t[i], s[0], s[1], s[2]};
    least_sq = std::min({least_sq, vertex_triangle(a).distance_sq, vertex_triangle(b).distance_sq});
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec3<double> e[4] = {s[i], s[(i + 1) % 3], t[j], t[(j + 1) % 3]};
      least_sq = std::min(least_sq, edge_edge(e).distance_sq);
    }
  }
  return std::sqrt(least_sq);
}

Vec3<double> random_point(std::uint64_t& state, double height) {
  const double x = next_random(state), y = next_random(state);
  return {x, y, height * next_random(state)};
}

/// Of random triangles with as many corners in common, in all orders of these.
void expect_true_of_triangles_that_share(Index shared) {
  std::uint64_t state = 5 + static_cast<std::uint64_t>(shared);
  for (const double height : {1.0, 0.1, 1e-3, 0.0}) {
    int said = 0, meeting = 0;
    for (int k = 0; k < 20000; ++k) {
      Corners s, t;
      Tri s_places{{0, 1, 2}}, t_places{{3, 4, 5}};
      for (std::size_t i = 0; i < 3; ++i) {
        s[i] = random_point(state, height);
        t[i] = random_point(state, height);
      }
      // Triangles of many sizes and shapes.
      const double size = std::pow(10.0, 4 * next_random(state) - 2);
      for (std::size_t i = 1; i < 3; ++i) t[i] = t[0] + size * (t[i] - t[0]);
      if (k % 5 == 0) t[2] = t[1] + 1e-4 * (t[2] - t[1]);
      const auto turn = static_cast<Index>(3 * next_random(state));
      const auto other = static_cast<Index>(3 * next_random(state));
      for (Index i = 0; i < shared; ++i) {
        const Index a = (turn + i) % 3, b = (other + 3 - i) % 3;
        t_places.v[b] = s_places.v[a];
        t[static_cast<std::size_t>(b)] = s[static_cast<std::size_t>(a)];
      }
      const double gap = shared == 0 && k % 2 == 0 ? 0.05 : 0;
      const bool meet = triangles_intersect(s_places, t_places, s, t);
      meeting += meet ? 1 : 0;
      const PlacedTriangle own = placed(s_places, s);
      if (!CullingPlanes(own).holds_off(placed(t_places, t), gap)) continue;
      ++said;
      EXPECT_FALSE(meet);
      if (shared == 0) {
        EXPECT_GT(distance_between(s, t), gap);
      }
    }
    EXPECT_GT(said, 2000) << height;
    EXPECT_GT(meeting, height > 0 || shared > 0 ? 100 : -1) << height;
  }
}

TEST(CullingPlanes, HoldsOffNothingThatMeetsWithoutACommonCorner) {
  expect_true_of_triangles_that_share(0);
}

TEST(CullingPlanes, HoldsOffNothingThatMeetsBeyondACommonCorner) {
  expect_true_of_triangles_that_share(1);
}

TEST(CullingPlanes, HoldsOffNothingThatMeetsBeyondACommonEdge) {
  expect_true_of_triangles_that_share(2);
}

TEST(CullingPlanes, HoldsOffMostOfAFanAndWhatLiesBelow) {
  const Corners own{{{0, 0, 0}, {1, 0, 0}, {0.5, 0.8, 0.1}}};
  const PlacedTriangle triangle = placed({{0, 1, 2}}, own);
  const CullingPlanes planes(triangle);
  const auto holds = [&](const Tri& places, const Corners& x, double gap) {
    return planes.holds_off(placed(places, x), gap);
  };
  EXPECT_TRUE(holds({{1, 0, 3}}, {{{1, 0, 0}, {0, 0, 0}, {0.4, -0.9, 0.2}}}, 0));
  EXPECT_TRUE(holds({{0, 4, 5}}, {{{0, 0, 0}, {-1, 0.2, 0}, {-0.7, -0.6, 0}}}, 0));
  // The same places under other numbers are points that touch.
  EXPECT_FALSE(holds({{6, 4, 5}}, {{{0, 0, 0}, {-1, 0.2, 0}, {-0.7, -0.6, 0}}}, 0));
  // The same number in another place is a seam that is open.
  EXPECT_TRUE(holds({{0, 4, 5}}, {{{-0.1, 0, 0}, {-1, 0.2, 0}, {-0.7, -0.6, 0}}}, 0));
  const Corners below{{{-0.2, 0, -0.1}, {1.2, 0, -0.1}, {0.5, 0.9, -0.1}}};
  EXPECT_TRUE(holds({{7, 8, 9}}, below, 0.05));
  EXPECT_FALSE(holds({{7, 8, 9}}, below, 0.2));
}

TEST(CullingPlanes, OfASliverSaysNothing) {
  const PlacedTriangle sliver = placed({{0, 1, 2}}, {{{0, 0, 0}, {1, 0, 0}, {0.5, 1e-4, 0}}});
  EXPECT_FALSE(
      CullingPlanes(sliver).holds_off(placed({{3, 4, 5}}, {{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}}}), 0));
}

}  // namespace
}  // namespace weft
