#include "host/io/pattern/edge_cuts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "host/io/pattern/edge_sampling.hpp"
#include "host/io/pattern/garment.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

/// A square of 1 m with its lower left corner at x. Edge 1 is its right side, edge 3 its left one,
/// which runs down.
PatternPanel square(const char* name, double x, std::vector<Vec2<double>> notches) {
  PatternPanel panel;
  panel.name = name;
  panel.vertices = {{x, 0}, {x + 1, 0}, {x + 1, 1}, {x, 1}};
  for (Index e = 0; e < 4; ++e) panel.edges.push_back({e, (e + 1) % 4});
  panel.notches = std::move(notches);
  return panel;
}

/// The right side of the first is sewn to the left side of the second.
SewingPattern two_squares(const std::vector<Vec2<double>>& first,
                          const std::vector<Vec2<double>>& second) {
  SewingPattern pattern;
  pattern.file = "t.json";
  pattern.panels = {square("a", 0, first), square("b", 1, second)};
  pattern.stitches = {{{{{0, 1}, {1, 3}}}}};
  return pattern;
}

/// Heights at which pairs of the seam are, on both sides.
std::vector<Vec2<double>> seam_heights(const Garment& garment) {
  std::vector<Vec2<double>> heights;
  for (const auto& [a, b] : garment.seams[0].pairs)
    heights.push_back({garment.mesh.positions[at(a)][1], garment.mesh.positions[at(b)][1]});
  return heights;
}

bool has_pair(const std::vector<Vec2<double>>& heights, double a, double b) {
  return std::any_of(heights.begin(), heights.end(), [&](const Vec2<double>& pair) {
    return std::abs(pair[0] - a) < 1e-9 && std::abs(pair[1] - b) < 1e-9;
  });
}

TEST(EdgeCuts, NotchesMeet) {
  // One on the outline, one a seam allowance beyond it; given in any order.
  const Garment garment =
      make_garment(two_squares({{1, 0.7}, {1.015, 0.25}}, {{1, 0.35}, {1, 0.6}}), 0.1);
  EXPECT_TRUE(garment.notes.empty());
  const std::vector<Vec2<double>> heights = seam_heights(garment);
  ASSERT_EQ(heights.size(), 11u);
  EXPECT_TRUE(has_pair(heights, 0, 0));
  EXPECT_TRUE(has_pair(heights, 0.25, 0.35));
  EXPECT_TRUE(has_pair(heights, 0.7, 0.6));
  EXPECT_TRUE(has_pair(heights, 1, 1));
  // In between, both sides are cut into equal parts.
  for (std::size_t k = 1; k < heights.size(); ++k)
    for (int side = 0; side < 2; ++side)
      EXPECT_GT(std::abs(heights[k][side] - heights[k - 1][side]), 0.05);
}

TEST(EdgeCuts, WithoutNotchesOnBothSidesPartsAreEqual) {
  // Alone; at a corner; far from the outline.
  for (const Vec2<double>& notch : {Vec2<double>{1, 0.33}, {1, 1}, {0.5, 0.5}}) {
    const Garment garment = make_garment(two_squares({notch}, {}), 0.1);
    EXPECT_TRUE(garment.notes.empty());
    for (const Vec2<double>& pair : seam_heights(garment)) EXPECT_NEAR(pair[0], pair[1], 1e-12);
  }
}

TEST(EdgeCuts, NotchesThatCannotMeetAreNamed) {
  const auto note = [](const std::vector<Vec2<double>>& first,
                       const std::vector<Vec2<double>>& second) {
    const Garment garment = make_garment(two_squares(first, second), 0.1);
    for (const Vec2<double>& pair : seam_heights(garment)) EXPECT_NEAR(pair[0], pair[1], 1e-12);
    return garment.notes.size() == 1 ? garment.notes[0] : "";
  };
  EXPECT_EQ(note({{1, 0.3}}, {{1, 0.3}, {1, 0.6}}),
            "pattern.stitches[0]: notches do not meet: 1 on one side, 2 on the other");
  EXPECT_EQ(note({{1, 0.1}}, {{1, 0.9}}),
            "pattern.stitches[0]: notches do not meet: the sides between them differ too much in "
            "length");
}

}  // namespace
}  // namespace weft::io
