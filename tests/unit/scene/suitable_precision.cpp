#include "host/scene/suitable_precision.hpp"

#include <gtest/gtest.h>

#include "weft/shapes.hpp"

namespace weft {
namespace {

/// 0.15 kg/m^2, 800 N/m, in steps of 5 ms.
Scene sheet(double size) {
  Scene scene;
  scene.time.step = 0.005;
  scene.materials.push_back({});
  scene.materials[0].density = 0.15;
  scene.materials[0].stretch_stiffness = 800;
  scene.materials[0].bending_stiffness = 1e-5;
  scene.cloths.push_back(
      {"cloth", make_grid({size, size}, {20, 20}, Diagonals::same), 0, {}, {}, {}, {}});
  return scene;
}

bool is_double(const Scene& scene) {
  return suitable_precision(scene) == Precision::double_precision;
}

TEST(SuitablePrecision, IsSingleForOrdinaryCloth) {
  EXPECT_FALSE(is_double(sheet(1)));
  EXPECT_FALSE(is_double(sheet(0.01)));
}

TEST(SuitablePrecision, IsDoubleWhereTheMassIsSmallOrTheStiffnessLarge) {
  EXPECT_TRUE(is_double(sheet(0.001)));
  Scene light = sheet(1);
  light.materials[0].density = 1e-9;
  EXPECT_TRUE(is_double(light));
  Scene stiff = sheet(1);
  stiff.materials[0].stretch_stiffness = 1e10;
  EXPECT_TRUE(is_double(stiff));
  stiff.materials[0].stretch_stiffness = 800;
  stiff.materials[0].orthotropic = OrthotropicStretch{800, 1e10, 0, 400};
  EXPECT_TRUE(is_double(stiff));
  Scene thick = sheet(1);
  thick.materials[0].bending_stiffness = 1e6;
  EXPECT_TRUE(is_double(thick));
  Scene slow = sheet(1);
  slow.time.step = 5;
  EXPECT_TRUE(is_double(slow));
  Scene damped = sheet(1);
  damped.materials[0].damping_stiffness = 1000;
  EXPECT_TRUE(is_double(damped));
}

TEST(SuitablePrecision, KnowsWhatRefinementMakes) {
  Scene scene = sheet(0.01);
  scene.refinement.when = Refinement::When::sewn;
  scene.refinement.levels = 3;
  EXPECT_TRUE(is_double(scene));
}

TEST(SuitablePrecision, IsDoubleForTheAsynchronousMethod) {
  Scene scene = sheet(1);
  scene.method = "asynchronous";
  EXPECT_TRUE(is_double(scene));
}

/// Materials without cloth count for nothing.
TEST(SuitablePrecision, SkipsMaterialsThatNothingIsMadeOf) {
  Scene scene = sheet(1);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].stretch_stiffness = 1e12;
  EXPECT_FALSE(is_double(scene));
}

}  // namespace
}  // namespace weft
