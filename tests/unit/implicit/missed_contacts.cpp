#include <gtest/gtest.h>

#include <ostream>

#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

// Contacts that a step's prediction missed join its system, which is solved again.

namespace weft {
namespace {

struct Stiff {
  double stretch_stiffness;  ///< [N/m]
  int newton_iterations;
};

void PrintTo(const Stiff& stiff, std::ostream* out) {
  *out << stiff.stretch_stiffness << " N/m, " << stiff.newton_iterations << " iterations";
}

class MissedContactsTest : public testing::TestWithParam<Stiff> {};

/// What solves again is Newton's method too: in stiff cloth a whole step of it, not searched along
/// for where forces are less, ends with tens of times the energy that the fall gave.
TEST_P(MissedContactsTest, GiveNoEnergyToTheFirstStepIntoThem) {
  Scene scene = test::sheet_on_sphere(Precision::single_precision, 28);
  scene.materials[0].stretch_stiffness = GetParam().stretch_stiffness;
  scene.solver.newton_iterations = GetParam().newton_iterations;
  scene.solver.newton_tolerance = 0.02;
  scene.solver.tolerance = 0.01;
  scene.time.step = 0.04;  // in which it falls from above the sphere to below its top
  Simulation simulation(scene, host_devices(1));
  const Energy before = simulation.energy();
  const StepReport report = simulation.step();
  ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
  EXPECT_GT(report.solves, report.newton_iterations) << "nothing was solved again";
  EXPECT_GT(report.stages.solve, 0);
  const Energy after = simulation.energy();
  const double fallen = before.gravitational - after.gravitational;
  EXPECT_GT(fallen, 0);
  EXPECT_LT(after.kinetic + after.elastic, 1.1 * fallen);
}

INSTANTIATE_TEST_SUITE_P(Newton, MissedContactsTest,
                         testing::Values(Stiff{10000, 3}, Stiff{20000, 4}, Stiff{20000, 8}));

}  // namespace
}  // namespace weft
