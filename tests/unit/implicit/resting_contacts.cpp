#include <gtest/gtest.h>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// Contacts that hang above the thickness are predicted to fall below it, in every step.
TEST(RestingContacts, OneSolveAStepIsMostlyEnough) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision);
  scene.time.step = 0.005;
  scene.contact.thickness = 0.001;
  scene.contact.friction = 0.3;
  scene.obstacles[0].friction = 0.3;
  Simulation simulation(scene, host_devices(1));
  for (int n = 0; n < 300; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
  int active_set_iterations = 0;
  for (int n = 0; n < 50; ++n) {
    const StepReport report = simulation.step();
    ASSERT_GT(report.proximities, 10);
    active_set_iterations += report.active_set_iterations;
  }
  EXPECT_LT(active_set_iterations, 25);
}

}  // namespace
}  // namespace weft
