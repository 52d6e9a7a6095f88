// Planted intersections of every kind, each beside a near miss that must come out clean.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host/lab/check/validator.hpp"
#include "tests/unit/lab/check/soup.hpp"

namespace weft::lab::test {
namespace {

const double past_one = std::nextafter(1.0, 2.0);
const double below_one = std::nextafter(1.0, 0.0);
const double past_half = std::nextafter(0.5, 1.0);
const double tiny = std::numeric_limits<double>::denorm_min();

struct Case {
  std::string name;
  Points points;  // six: two separate triangles; five: they share 0; four: they share 0 and 1
  bool meets;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

/// Corners in every order, both triangles in either place: the verdict must not depend on it.
void expect_verdict(const Points& points, Tri s, Tri t, bool meets) {
  std::sort(s.v, s.v + 3);
  do {
    std::sort(t.v, t.v + 3);
    do {
      for (const bool swap : {false, true}) {
        const Mesh mesh = mesh_of(points, swap ? std::vector{t, s} : std::vector{s, t});
        const FrameVerdict verdict = validate(mesh, nullptr);
        ASSERT_EQ(verdict.cloth_cloth_count, meets ? 1 : 0)
            << s.v[0] << s.v[1] << s.v[2] << " " << t.v[0] << t.v[1] << t.v[2] << " " << swap;
        const TrianglePair pair{PairKind::cloth_cloth, 0, 1};
        ASSERT_EQ(verdict.pairs, std::vector<TrianglePair>(meets ? 1 : 0, pair));
        ASSERT_EQ(verdict.clean(), !meets);
      }
    } while (std::next_permutation(t.v, t.v + 3));
  } while (std::next_permutation(s.v, s.v + 3));
}

class Planted : public testing::TestWithParam<Case> {};

TEST_P(Planted, IsJudgedRight) {
  const Case& c = GetParam();
  switch (c.points.size()) {
    case 6:
      return expect_verdict(c.points, {{0, 1, 2}}, {{3, 4, 5}}, c.meets);
    case 5:
      return expect_verdict(c.points, {{0, 1, 2}}, {{0, 3, 4}}, c.meets);
    default:
      return expect_verdict(c.points, {{0, 1, 2}}, {{0, 1, 3}}, c.meets);
  }
}

/// Against an obstacle nothing is shared: pairs of separate triangles must come out the same.
TEST_P(Planted, IsJudgedRightAgainstAnObstacle) {
  const Case& c = GetParam();
  if (c.points.size() != 6) return;
  const Mesh cloth = mesh_of({c.points.begin(), c.points.begin() + 3}, {{{0, 1, 2}}});
  const Mesh obstacle = mesh_of({c.points.begin() + 3, c.points.end()}, {{{0, 1, 2}}});
  const FrameVerdict verdict = validate(cloth, &obstacle);
  EXPECT_EQ(verdict.cloth_obstacle_count, c.meets ? 1 : 0);
  EXPECT_EQ(verdict.cloth_cloth_count, 0);
  EXPECT_EQ(verdict.clean(), !c.meets);
  const TrianglePair pair{PairKind::cloth_obstacle, 0, 0};
  EXPECT_EQ(verdict.pairs, std::vector<TrianglePair>(c.meets ? 1 : 0, pair));
}

/// The first triangle of most cases; its long edge lies on x + y = 2.
Points over(const Points& second) {
  Points points{{0, 0, 1}, {2, 0, 1}, {0, 2, 1}};
  points.insert(points.end(), second.begin(), second.end());
  return points;
}

INSTANTIATE_TEST_SUITE_P(
    Separate, Planted,
    testing::Values(
        Case{"EdgeThroughFace", over({{.5, .5, 0}, {.5, .5, 2}, {3, 3, .5}}), true},
        Case{"EdgeThroughEdge", over({{1, 1, 0}, {1, 1, 2}, {3, 3, .5}}), true},
        Case{"EdgePastEdgeByOneUlp", over({{past_one, 1, 0}, {past_one, 1, 2}, {3, 3, .5}}), false},
        Case{"EdgePastEdgeBy1e12", over({{1 + 1e-12, 1, 0}, {1 + 1e-12, 1, 2}, {3, 3, .5}}), false},
        Case{"EdgeInsideEdgeByOneUlp", over({{below_one, 1, 0}, {below_one, 1, 2}, {3, 3, .5}}),
             true},
        Case{"VertexOnFace", over({{.5, .5, 1}, {.5, .5, 2}, {1, .5, 2}}), true},
        Case{"VertexAboveFaceByOneUlp", over({{.5, .5, past_one}, {.5, .5, 2}, {1, .5, 2}}), false},
        Case{"VertexAboveFaceBy1e12", over({{.5, .5, 1 + 1e-12}, {.5, .5, 2}, {1, .5, 2}}), false},
        Case{"VertexBelowFaceByOneUlp", over({{.5, .5, below_one}, {.5, .5, 2}, {1, .5, 2}}), true},
        Case{"VertexOnEdge", over({{1, 1, 1}, {2, 2, 2}, {2, 2, 0}}), true},
        Case{"VertexPastEdgeByOneUlp", over({{past_one, 1, 1}, {2, 2, 2}, {2, 2, 0}}), false},
        Case{"VertexPastEdgeBy1e12", over({{1 + 1e-12, 1, 1}, {2, 2, 2}, {2, 2, 0}}), false},
        Case{"VertexOnVertex", over({{2, 0, 1}, {3, 0, 2}, {3, 0, 0}}), true},
        Case{"VertexBesideVertexByOneUlp",
             over({{std::nextafter(2.0, 3.0), 0, 1}, {3, 0, 2}, {3, 0, 0}}), false},
        Case{"EdgeOnEdge", over({{0, 0, 1}, {2, 0, 1}, {1, -1, 2}}), true},
        Case{"EdgeBesideEdgeByTheLeast", over({{0, -tiny, 1}, {2, -tiny, 1}, {1, -1, 2}}), false},
        Case{"EdgeInFace", over({{.25, .25, 1}, {.5, .25, 1}, {.5, .25, 2}}), true},
        Case{"EdgeOverFaceByOneUlp",
             over({{.25, .25, past_one}, {.5, .25, past_one}, {.5, .25, 2}}), false}));

INSTANTIATE_TEST_SUITE_P(
    Coplanar, Planted,
    testing::Values(
        Case{"Overlap", over({{.5, .5, 1}, {3, .5, 1}, {.5, 3, 1}}), true},
        Case{"OneInsideTheOther", over({{.25, .25, 1}, {.5, .25, 1}, {.25, .5, 1}}), true},
        Case{"OverlapLiftedByOneUlp",
             over({{.5, .5, past_one}, {3, .5, past_one}, {.5, 3, past_one}}), false},
        Case{"OverlapLiftedBy1e12",
             over({{.5, .5, 1 + 1e-12}, {3, .5, 1 + 1e-12}, {.5, 3, 1 + 1e-12}}), false},
        Case{"Identical", over({{0, 0, 1}, {2, 0, 1}, {0, 2, 1}}), true},
        Case{"IdenticalLiftedByOneUlp",
             over({{0, 0, past_one}, {2, 0, past_one}, {0, 2, past_one}}), false},
        // A star of six points: every edge crosses, no corner lies in the other triangle.
        Case{"EdgesCross", over({{-1, .5, 1}, {1.5, .75, 1}, {.75, -1, 1}}), true},
        Case{"VertexOnEdge", over({{1, 1, 1}, {3, 2, 1}, {2, 3, 1}}), true},
        Case{"VertexPastEdgeByOneUlp", over({{past_one, 1, 1}, {3, 2, 1}, {2, 3, 1}}), false},
        Case{"EdgeOnEdge", over({{2, 0, 1}, {0, 2, 1}, {2, 2, 1}}), true},
        Case{"EdgePastEdgeByOneUlp", over({{1.5, past_half, 1}, {past_half, 1.5, 1}, {2, 2, 1}}),
             false},
        Case{"SideBySideOnALineByTheLeast", over({{-tiny, 0, 1}, {-2, 0, 1}, {-1, 2, 1}}), false},
        // The plane x + y + z = 1 holds no coordinate plane; its points here are exact.
        Case{"TiltedOverlap",
             {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {.25, .25, .5}, {.5, 0, .5}, {1, 1, -1}},
             true},
        Case{"TiltedOverlapLiftedByOneUlp",
             {{1, 0, 0},
              {0, 1, 0},
              {0, 0, 1},
              {.25, .25, past_half},
              {.5, 0, past_half},
              {1, 1, -below_one}},
             false}));

INSTANTIATE_TEST_SUITE_P(
    SharedEdge, Planted,
    testing::Values(
        Case{"Unfolded", {{0, 0, 0}, {1, 0, 0}, {.5, 1, 0}, {.5, -1, 0}}, false},
        Case{"Bent", {{0, 0, 0}, {1, 0, 0}, {.5, 1, 0}, {.5, 0, 1}}, false},
        Case{"FoldedFlat", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.25, .75, 0}}, true},
        Case{"FoldedAlmostFlatByTheLeast",
             {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.25, .75, tiny}},
             false},
        Case{"FoldedAlmostFlatBy1e12", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.25, .75, 1e-12}}, false},
        Case{"FoldedFlatBeside", {{0, 0, 0}, {1, 0, 0}, {-3, 1, 0}, {4, 1, 0}}, true},
        Case{"FoldedOntoItself", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}}, true},
        Case{"FoldedFlatTilted", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {.25, .25, .5}}, true},
        Case{"FoldedAlmostFlatTiltedByOneUlp",
             {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {.25, .25, past_half}},
             false},
        Case{"UnfoldedTilted", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {.75, .75, -.5}}, false}));

INSTANTIATE_TEST_SUITE_P(
    SharedVertex, Planted,
    testing::Values(
        Case{"Apart", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {-1, -1, 1}, {-1, -1, -1}}, false},
        Case{"Pierced", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {.5, .5, 1}, {.5, .5, -1}}, true},
        Case{"PiercedBeyondTheFarEdge",
             {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {4, 4, 1}, {4, 4, -1}},
             true},
        Case{"AboveByTheLeast",
             {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {.5, .5, 1}, {.5, .5, tiny}},
             false},
        Case{"AboveBy1e12", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {.5, .5, 1}, {.5, .5, 1e-12}}, false},
        Case{"VertexOnFace", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {.5, .5, 1}, {.5, .5, 0}}, true},
        Case{"PlaneThroughEdge", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 1}, {1, 0, -1}}, true},
        Case{"PlanePastEdgeByTheLeast",
             {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, -tiny, 1}, {1, -tiny, -1}},
             false},
        Case{"PlanePastEdgeBy1e12",
             {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, -1e-12, 1}, {1, -1e-12, -1}},
             false},
        Case{"CoplanarApart", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {-1, 0, 0}, {0, -1, 0}}, false},
        Case{"CoplanarOverlap", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 2, 0}, {2, 1, 0}}, true},
        Case{"CoplanarSides", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 0}, {0, -1, 0}}, true},
        Case{"CoplanarSidesApartByTheLeast",
             {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, -tiny, 0}, {0, -1, 0}},
             false},
        Case{"OppositeSides", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {-2, 0, 0}, {0, -2, 0}}, false},
        Case{"Identical", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 0, 0}, {0, 2, 0}}, true},
        Case{"OtherEndsMeet", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 0, 0}, {2, 0, 2}}, true},
        Case{"OtherEndsApartByOneUlp",
             {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, -tiny, 0}, {2, -tiny, 2}},
             false}));

TEST(ValidatorIntersections, SameThreeVerticesTwiceIsAnIntersection) {
  const Mesh mesh = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}, {{1, 0, 2}}});
  EXPECT_EQ(validate(mesh, nullptr).cloth_cloth_count, 1);
}

TEST(ValidatorIntersections, ObstacleAgainstItselfIsIgnored) {
  const Mesh crossing =
      mesh_of({{0, 0, 1}, {2, 0, 1}, {0, 2, 1}, {.5, .5, 0}, {.5, .5, 2}, {3, 3, 1}},
              {{{0, 1, 2}}, {{3, 4, 5}}});
  const Mesh cloth = mesh_of({{9, 0, 1}, {10, 0, 1}, {9, 1, 1}}, {{{0, 1, 2}}});
  EXPECT_EQ(validate(crossing, nullptr).cloth_cloth_count, 1);
  const FrameVerdict verdict = validate(cloth, &crossing);
  EXPECT_TRUE(verdict.clean());
  EXPECT_EQ(verdict.obstacle_triangle_count, 2);
}

TEST(ValidatorIntersections, OptionsLeaveKindsOut) {
  const Mesh crossing =
      mesh_of({{0, 0, 1}, {2, 0, 1}, {0, 2, 1}, {.5, .5, 0}, {.5, .5, 2}, {3, 3, 1}},
              {{{0, 1, 2}}, {{3, 4, 5}}});
  ValidatorOptions options;
  options.self = false;
  EXPECT_EQ(validate(crossing, &crossing, options).cloth_cloth_count, 0);
  EXPECT_EQ(validate(crossing, &crossing, options).cloth_obstacle_count, 4);
  options = {};
  options.obstacle = false;
  EXPECT_EQ(validate(crossing, &crossing, options).cloth_cloth_count, 1);
  EXPECT_EQ(validate(crossing, &crossing, options).cloth_obstacle_count, 0);
}

TEST(ValidatorIntersections, ListIsCutOffButTheCountIsNot) {
  // n copies of one triangle: every pair meets.
  Mesh mesh;
  const int n = 120;
  for (int i = 0; i < n; ++i)
    append(mesh, mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}}));
  const FrameVerdict all = validate(mesh, nullptr);
  EXPECT_EQ(all.cloth_cloth_count, n * (n - 1) / 2);
  EXPECT_EQ(all.pairs.size(), 1000u);
  EXPECT_TRUE(std::is_sorted(all.pairs.begin(), all.pairs.end()));
  ValidatorOptions options;
  options.list_limit = 3;
  const FrameVerdict few = validate(mesh, nullptr, options);
  EXPECT_EQ(few.cloth_cloth_count, n * (n - 1) / 2);
  const auto kind = PairKind::cloth_cloth;
  EXPECT_EQ(few.pairs, (std::vector<TrianglePair>{{kind, 0, 1}, {kind, 0, 2}, {kind, 0, 3}}));
}

}  // namespace
}  // namespace weft::lab::test
