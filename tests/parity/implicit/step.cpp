#include "host/exec/host_devices.hpp"
#include "host/scene/intersection_check.hpp"
#include "tests/parity/support.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

// Whole steps: a scene on CUDA agrees with the host until contact makes trajectories diverge, gives
// the same bits from run to run and for any number of ranks, and ends without an intersection.

namespace weft::parity {
namespace {

constexpr int steps = 24;

struct StepCase {
  std::string name;
  Scene scene;
  bool touches;
};

/// Solved as far as the precision allows, so that what is left is rounding.
Scene exactly(Scene scene) {
  scene.solver.tolerance = scene.precision == Precision::single_precision ? 1e-5 : 1e-11;
  return scene;
}

Scene with_newton(Scene scene) {
  scene.solver.newton_iterations = 4;
  scene.wind = {1.2, {2, 1, 0}, 0.05};
  return scene;
}

Scene with_limits(Scene scene) {
  scene.materials[0].strain_limits = StrainLimits{0.97, 1.03};
  scene.cloths[0].pressure = 2;
  return scene;
}

std::vector<StepCase> step_cases() {
  constexpr Precision one = Precision::single_precision;
  constexpr Precision two = Precision::double_precision;
  return {
      {"SheetOnSphereFloat", test::sheet_on_sphere(one), true},
      {"SheetOnSphereDouble", test::sheet_on_sphere(two), true},
      {"TwoSheets", test::two_sheets(one), true},
      {"HangingSheetBdf2", test::hanging_sheet(two, Integrator::bdf2), false},
      {"ReleasedSheet", test::released_sheet(one), false},
      {"CurledSheet", test::curled_sheet(two, Bending::plate), false},
      {"Hinges", test::curled_sheet(one, Bending::hinge), false},
      {"NewtonInTheWind", with_newton(test::sheet_on_sphere(two, 10)), true},
      {"StrainLimits", with_limits(test::hanging_sheet(two, Integrator::implicit_euler)), false}};
}

struct Outcome {
  std::vector<Vec3<double>> before_contact;  ///< [m] cloth, as long as nothing was close
  Frame frame;                               ///< the last
  std::uint64_t hash = 0;
  int free_steps = 0;
  bool touched = false;
  int truncations = 0;
  std::string failure;
};

Outcome run(const Scene& scene, DeviceSet devices) {
  Simulation simulation(scene, std::move(devices));
  Outcome out;
  for (int k = 0; k < steps && out.failure.empty(); ++k) {
    const StepReport r = simulation.step();
    if (r.failure != Failure::none) out.failure = describe(r.failure) + (": " + r.failure_detail);
    out.truncations += r.truncations;
    out.touched = out.touched || r.proximities > 0 || r.impacts > 0;
    if (out.touched) continue;
    ++out.free_steps;
    out.before_contact.clear();
    for (const auto& cloth : simulation.frame().cloth_positions)
      out.before_contact.insert(out.before_contact.end(), cloth.begin(), cloth.end());
  }
  out.frame = simulation.frame();
  out.hash = simulation.state_hash();
  return out;
}

/// @throws SceneError if the frame has an intersection
void expect_untangled(Scene scene, const Frame& frame) {
  const auto stand = [](Mesh& mesh, Transform& transform, const std::vector<Vec3<double>>& at) {
    mesh.positions = at;
    transform = {};
  };
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    scene.cloths[c].mesh.positions = frame.cloth_positions[c];
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    stand(scene.obstacles[o].mesh, scene.obstacles[o].transform, frame.simulated_obstacle(o));
    scene.obstacles[o].motion.clear();
  }
  EXPECT_NO_THROW(refuse_intersecting_start(scene));
}

class StepParity : public testing::TestWithParam<StepCase> {};

TEST_P(StepParity, CudaAgreesWithHost) {
  const Scene scene = exactly(GetParam().scene);
  const Outcome host = run(scene, host_devices(1, {.poison = true}));
  EXPECT_EQ(host.failure, "");
  EXPECT_EQ(host.touched, GetParam().touches);
  ASSERT_GT(host.free_steps, 0);
  std::string why;
  std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const Outcome found = run(scene, std::move(*cuda));
  EXPECT_EQ(found.failure, "");
  EXPECT_EQ(found.touched, host.touched);
  ASSERT_EQ(found.free_steps, host.free_steps);
  // What the solver leaves, summed over the steps.
  const double tolerance = scene.precision == Precision::single_precision ? 2e-5 : 1e-9;
  double distance = 0;
  for (std::size_t v = 0; v < host.before_contact.size(); ++v)
    distance = std::max(distance, length(found.before_contact[v] - host.before_contact[v]));
  EXPECT_LT(distance, tolerance);
  expect_untangled(scene, found.frame);
}

TEST_P(StepParity, CudaGivesTheSameBitsOnAnyNumberOfRanks) {
  const Scene& scene = GetParam().scene;
  std::string why;
  std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const Outcome one = run(scene, std::move(*cuda));
  EXPECT_EQ(one.failure, "");
  for (const std::vector<int>& gpus : gpu_lists()) {
    std::optional<DeviceSet> several = find_cuda(gpus, why);
    EXPECT_EQ(one.hash, run(scene, std::move(*several)).hash)
        << gpus.size() << " ranks, the last on GPU " << gpus.back();
  }
  expect_untangled(scene, one.frame);
}

/// Rows change owners before each step, queries with each search.
TEST_P(StepParity, RebalancingKeepsTheBits) {
  Scene scene = GetParam().scene;
  std::string why;
  std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const Outcome one = run(scene, std::move(*cuda));
  scene.solver.rebalance = Rebalance::every_step;
  for (const std::vector<int>& gpus : gpu_lists()) {
    std::optional<DeviceSet> several = find_cuda(gpus, why);
    EXPECT_EQ(one.hash, run(scene, std::move(*several)).hash)
        << gpus.size() << " ranks, the last on GPU " << gpus.back();
  }
}

TEST(TruncatedStepParity, CudaGivesTheSameBitsOnAnyNumberOfRanks) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const Scene scene = test::folded_napkin(precision);
    std::string why;
    std::optional<DeviceSet> cuda = find_cuda({0}, why);
    if (!cuda) GTEST_SKIP() << why;
    const Outcome one = run(scene, std::move(*cuda));
    EXPECT_EQ(one.failure, "");
    EXPECT_GT(one.truncations, 0);
    for (const std::vector<int>& gpus : gpu_lists()) {
      std::optional<DeviceSet> several = find_cuda(gpus, why);
      EXPECT_EQ(one.hash, run(scene, std::move(*several)).hash)
          << gpus.size() << " ranks, the last on GPU " << gpus.back();
    }
    expect_untangled(scene, one.frame);
  }
}

INSTANTIATE_TEST_SUITE_P(All, StepParity, testing::ValuesIn(step_cases()),
                         [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace weft::parity
