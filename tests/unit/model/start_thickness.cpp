#include "host/model/start_thickness.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "weft/elements/contact.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double thickness = 1e-3;  ///< [m]

/// Sheets of 0.1 m at these heights, without gravity.
Scene sheets(const std::vector<double>& heights, Index cells = 4) {
  Scene scene;
  scene.gravity = {0, 0, 0};
  scene.contact.thickness = thickness;
  scene.materials.push_back({});
  for (const double z : heights) {
    Cloth cloth;
    cloth.mesh = make_grid({0.1, 0.1}, {cells, cells}, Diagonals::alternating);
    for (Vec3<double>& x : cloth.mesh.positions) x[2] = z;
    scene.cloths.push_back(std::move(cloth));
  }
  return scene;
}

std::vector<double> of(const Scene& scene) {
  return make_model(scene).start_thickness;
}

TEST(StartThickness, IsTheSmallestGapOfWhatStartsNearer) {
  const std::vector<double> gaps = of(sheets({0, 0.3e-3, 0.9e-3}));
  ASSERT_EQ(gaps.size(), 75u);
  EXPECT_EQ(std::count_if(gaps.begin(), gaps.end(),
                          [](double g) { return std::abs(g - 0.3e-3) < 1e-12; }),
            50);
  EXPECT_EQ(std::count_if(gaps.begin(), gaps.end(),
                          [](double g) { return std::abs(g - 0.6e-3) < 1e-12; }),
            25);
}

TEST(StartThickness, IsThatOfTheSceneWhereNothingIsNearer) {
  EXPECT_TRUE(of(sheets({0, 1.01e-3})).empty());
  // By rounding only.
  EXPECT_TRUE(of(sheets({0, (1 - 1e-7) * thickness})).empty());
  EXPECT_FALSE(of(sheets({0, 0.99 * thickness})).empty());
  // The other half of a sheet that starts askew.
  Scene askew = sheets({0, 0});
  for (Vec3<double>& x : askew.cloths[1].mesh.positions) x[2] = 0.5e-3 + 0.1 * (x[0] + 0.05);
  const std::vector<double> gaps = of(askew);
  EXPECT_NEAR(*std::min_element(gaps.begin(), gaps.end()), 0.5e-3, 1e-5);
  EXPECT_EQ(*std::max_element(gaps.begin(), gaps.end()), thickness);
}

TEST(StartThickness, IsAtLeastWhatAPenaltyCanHold) {
  for (const double gap : of(sheets({0, 1e-9}))) EXPECT_EQ(gap, rest_least * thickness);
}

TEST(StartThickness, NeighboursOfOneClothDoNotCount) {
  // Cells of a third of the thickness, at rest and pushed together; then as if of two cloths.
  Scene fine = sheets({0}, 24);
  fine.contact.thickness = 0.1 / 8;
  EXPECT_TRUE(of(fine).empty());
  for (Vec3<double>& x : fine.cloths[0].mesh.positions) x[0] *= 0.95;
  EXPECT_TRUE(of(fine).empty());
  fine.cloths.push_back(fine.cloths[0]);
  for (Vec3<double>& x : fine.cloths[1].mesh.positions) x[0] += 0.1;
  EXPECT_FALSE(of(fine).empty());
}

/// Pairs of a cloth that starts flat are left out at once: it must not matter how it lies.
TEST(StartThickness, OfFlatClothIsThatOfTheSceneHoweverItLies) {
  Scene turned = sheets({0}, 24);
  turned.contact.thickness = 0.1 / 8;
  const double s = std::sin(0.7), c = std::cos(0.7);
  for (Vec3<double>& x : turned.cloths[0].mesh.positions)
    x = {c * x[0] + 3, s * x[0] - 2, x[1] + 5};
  EXPECT_TRUE(of(turned).empty());
  // A corner that is turned over lies on the rest, in the same plane.
  Scene folded = sheets({0}, 24);
  for (Vec3<double>& x : folded.cloths[0].mesh.positions)
    if (x[0] + x[1] > 0.061) x = {0.061 - x[1], 0.061 - x[0], 0.4e-3};
  EXPECT_FALSE(of(folded).empty());
}

TEST(StartThickness, DoesNotDependOnWhatARunHasWelded) {
  // Welded, two corners of the outer sheets would start at their mean place, on the middle one.
  Scene scene = sheets({-0.01, 0, 0.01});
  Seam seam;
  seam.cloths[0] = 0;
  seam.cloths[1] = 2;
  for (auto& side : seam.vertices) side.push_back(0);
  scene.seams.push_back(seam);
  EXPECT_TRUE(of(scene).empty());
  EXPECT_TRUE(make_model(scene, {1}).start_thickness.empty());
  for (Vec3<double>& x : scene.cloths[2].mesh.positions) x[2] = 0.4e-3;
  const Model apart = make_model(scene);
  const Model sewn = make_model(scene, {1});
  ASSERT_EQ(sewn.start_thickness.size(), 74u);
  for (std::size_t i = 0; i < sewn.to_internal.size(); ++i)
    EXPECT_LE(sewn.start_thickness[static_cast<std::size_t>(sewn.to_internal[i])],
              apart.start_thickness[static_cast<std::size_t>(apart.to_internal[i])]);
}

TEST(StartThickness, AsksForSelfContactAndAMethodThatKnowsOfIt) {
  Scene scene = sheets({0, 0.3e-3});
  scene.contact.self = false;
  EXPECT_TRUE(of(scene).empty());
  Obstacle table;
  table.mesh = make_box({1, 1, 0.1}, {1, 1, 1});
  table.transform.translate = {0, 0, -0.055};
  scene.obstacles.push_back(std::move(table));
  scene.contact.thickness = 6e-3;
  EXPECT_TRUE(of(scene).empty());  // misses the thickness by less than an edge
  scene.contact.thickness = 0.2;
  const std::vector<double> gaps = of(scene);
  ASSERT_FALSE(gaps.empty());
  EXPECT_NEAR(*std::min_element(gaps.begin(), gaps.end()), 5e-3, 1e-12);
  scene.method = "asynchronous";
  scene.precision = Precision::double_precision;
  EXPECT_TRUE(of(scene).empty());
}

/// [m] largest move of a vertex in ten steps
double largest_move(const Scene& scene) {
  Simulation simulation(scene, host_devices(1));
  const Frame before = simulation.frame();
  for (int n = 0; n < 10; ++n) {
    const StepReport report = simulation.step();
    EXPECT_EQ(report.failure, Failure::none) << report.failure_detail;
  }
  const Frame after = simulation.frame();
  double largest = 0;
  for (std::size_t c = 0; c < before.cloth_positions.size(); ++c)
    for (std::size_t v = 0; v < before.cloth_positions[c].size(); ++v)
      largest =
          std::max(largest, length(after.cloth_positions[c][v] - before.cloth_positions[c][v]));
  return largest;
}

TEST(StartThickness, WhatIsAtRestStaysAtRest) {
  // A deck of cards thinner than their contact, and a sheet in front of a ball.
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    Scene deck = sheets({0, 0.3e-3, 0.6e-3, 0.9e-3});
    deck.precision = precision;
    // Rounding of positions of 0.1 m moves a layer by as much per step, and steps add up.
    EXPECT_LT(largest_move(deck), precision == Precision::single_precision ? 1e-6 : 1e-12);
  }
  Scene thick = sheets({0.051});
  thick.contact.thickness = 0.05;
  Obstacle ball;
  ball.mesh = make_icosphere(0.05, 3);
  thick.obstacles.push_back(std::move(ball));
  EXPECT_LT(largest_move(thick), 1e-6);
}

TEST(StartThickness, SlidingLayersKeepTheirGap) {
  Scene deck = sheets({0, 0.3e-3});
  // Where edges of one sheet start on those of the other, rounding decides how they pass.
  for (Vec3<double>& x : deck.cloths[1].mesh.positions) x += Vec3<double>{0.003, 0.005, 0};
  deck.contact.friction = 0;
  deck.cloths[1].velocity = {1, 0, 0};  // two cells in 0.05 s
  Simulation simulation(deck, host_devices(1));
  for (int n = 0; n < 10; ++n) ASSERT_EQ(simulation.step().failure, Failure::none);
  const Frame frame = simulation.frame();
  EXPECT_GT(frame.cloth_positions[1][0][0], deck.cloths[1].mesh.positions[0][0] + 0.04);
  for (const Vec3<double>& x : frame.cloth_positions[1]) EXPECT_NEAR(x[2], 0.3e-3, 2e-5);
}

}  // namespace
}  // namespace weft
