// What can be told of a scene without simulating it.
#include "host/lab/plan/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "tests/support/small_scenes.hpp"

namespace weft::lab {
namespace {

StagePlan stage(const Scene& scene, const std::string& name) {
  const auto stages = plan_stages(scene);
  const auto found = std::find_if(stages.begin(), stages.end(),
                                  [&](const StagePlan& s) { return s.stage == name; });
  if (found == stages.end()) throw std::runtime_error("no stage " + name);
  return *found;
}

TEST(Plan, WhatIsNotThereIsLeftOut) {
  Scene scene = test::hanging_sheet(Precision::single_precision, Integrator::implicit_euler);
  for (const char* name : {"contact with obstacles", "motion of obstacles", "wind", "pressure",
                           "handles", "seams", "refinement", "strain limits"})
    EXPECT_EQ(stage(scene, name).verdict, Verdict::left_out) << name;
  EXPECT_EQ(stage(scene, "self-contact").verdict, Verdict::needed);
  scene.contact.self = false;
  EXPECT_EQ(stage(scene, "self-contact").verdict, Verdict::left_out);
  // Nothing touches anything now.
  EXPECT_EQ(stage(scene, "friction").setting, "model.friction=false");
}

TEST(Plan, WhatIsThereIsNeeded) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  scene.wind.density = 1.2;
  for (const char* name : {"contact with obstacles", "friction", "wind", "stretching", "damping"})
    EXPECT_EQ(stage(scene, name).verdict, Verdict::needed) << name;
  EXPECT_EQ(stage(scene, "motion of obstacles").verdict, Verdict::left_out);
  Transform there;
  there.translate = {0, 0, 1};
  scene.obstacles[0].motion = {{0, {}}, {1, there}};
  EXPECT_EQ(stage(scene, "motion of obstacles").verdict, Verdict::needed);
}

TEST(Plan, SaysWhereSelfContactIsProvedAwayAtTheStart) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  const auto why = [&] { return stage(scene, "self-contact").why; };
  EXPECT_NE(why().find("the cloth provably cannot reach itself"), std::string::npos) << why();
  for (auto& x : scene.cloths[0].mesh.positions)
    if (x[0] > 0.05) x = {0.1 - x[0], x[1], x[2] + 0.02};  // folded over
  EXPECT_NE(why().find("it is folded"), std::string::npos) << why();
  scene = test::two_sheets(Precision::single_precision);
  EXPECT_NE(why().find("the cloth provably cannot reach itself"), std::string::npos) << why();
  scene.cloths[1].velocity = {0, 0, -3};
  EXPECT_NE(why().find("nothing proves"), std::string::npos) << why();
  scene.contact.thickness = 0.05;
  EXPECT_NE(why().find("as fine as the thickness"), std::string::npos) << why();
  scene.cloths[0].mesh.triangles.pop_back();
  EXPECT_NE(why().find("not one convex panel"), std::string::npos) << why();
  scene.contact.self_certificate = false;
  EXPECT_NE(why().find("self_certificate is false"), std::string::npos) << why();
}

TEST(Plan, BendingIsMeasuredByTheEdges) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  Material& m = scene.materials[0];
  // The length of the sheet's edges, alternating diagonals included, lies between a cell and 1.5.
  EXPECT_GT(mean_edge(scene), 0.4 / 14);
  EXPECT_LT(mean_edge(scene), 1.5 * 0.4 / 14);
  m.bending_stiffness = m.density * 9.81 * std::pow(0.1, 3);
  EXPECT_NEAR(bending_length(scene), 0.1, 1e-12);
  EXPECT_EQ(stage(scene, "bending").verdict, Verdict::needed);
  m.bending_stiffness *= std::pow(0.05, 3);
  EXPECT_EQ(stage(scene, "bending").verdict, Verdict::offered);
  m.bending_stiffness = 0;
  EXPECT_EQ(stage(scene, "bending").verdict, Verdict::left_out);
}

TEST(Plan, PrecisionFollowsTheDistanceFromTheOrigin) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  EXPECT_EQ(stage(scene, "double precision").verdict, Verdict::left_out);
  scene.obstacles[0].transform.translate = {400, 0, 0};
  EXPECT_NEAR(largest_coordinate(scene), 400.1, 0.1);
  EXPECT_EQ(stage(scene, "double precision").setting, "precision=double");
  scene.precision = Precision::double_precision;
  EXPECT_EQ(stage(scene, "double precision").verdict, Verdict::needed);
}

}  // namespace
}  // namespace weft::lab
