#include "benchmarks/support/grid_system.hpp"
#include "host/exec/host_devices.hpp"
#include "tests/parity/support.hpp"

// Assembly and solve together, in the order of the step: the first system of a wavy sheet.
// CudaTakesMoreContacts is also a case for compute-sanitizer's memcheck: what is written past an
// array seldom shows in the results.

namespace weft::parity {
namespace {

template <class T>
struct FirstStep {
  Scene scene = wavy_sheet(40);
  double tolerance = sizeof(T) == sizeof(float) ? 1e-5 : 1e-11;
  bool folded;

  explicit FirstStep(Preconditioner preconditioner, Bending bending, bool with_contacts)
      : folded(with_contacts) {
    scene.wind = {1.25, {2, 1, 0.5}, 0.0625};
    scene.bending = bending;
    scene.solver.preconditioner = preconditioner;
    scene.solver.tolerance = tolerance;
    scene.solver.partial_rows = 128;
  }

  Outputs velocities(DeviceSet devices) const {
    FirstSystem<T> system(scene, std::move(devices), folded);
    return velocities(system);
  }
  Outputs velocities(FirstSystem<T>& system) const {
    system.assemble();
    system.solve();
    system.sync();
    EXPECT_EQ(system.status().converged, 1);
    EXPECT_GT(system.status().iterations, 5);
    return {output("velocities", system.velocities())};
  }
};

template <class T>
class LinearSystemParity : public testing::Test {
 protected:
  std::vector<FirstStep<T>> cases_ = {
      FirstStep<T>(Preconditioner::block_jacobi, Bending::hinge, false),
      FirstStep<T>(Preconditioner::multilevel, Bending::plate, false),
      FirstStep<T>(Preconditioner::multilevel, Bending::plate, true)};
};

using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(LinearSystemParity, Scalars);

TYPED_TEST(LinearSystemParity, CudaAgreesWithHost) {
  for (const auto& step : this->cases_) {
    const Outputs host = step.velocities(host_devices(1, {.poison = true}));
    expect_same_bits(step.velocities(host_devices(3, {.poison = true})), host);
    std::string why;
    std::optional<DeviceSet> cuda = find_cuda({0}, why);
    if (!cuda) GTEST_SKIP() << why;
    const Outputs found = step.velocities(std::move(*cuda));
    // What the solver's tolerance leaves, times the condition of a sheet of 40 cells.
    expect_close(found, host, 200 * step.tolerance);
    for (const std::vector<int>& gpus : gpu_lists()) {
      std::optional<DeviceSet> several = find_cuda(gpus, why);
      expect_same_bits(step.velocities(std::move(*several)), found);
    }
  }
}

/// Arrays grow with a quarter to spare: counts within that room and beyond it.
TYPED_TEST(LinearSystemParity, CudaTakesMoreContacts) {
  std::string why;
  if (!find_cuda({0}, why)) GTEST_SKIP() << why;
  for (const auto& step : this->cases_) {
    if (!step.folded) continue;
    for (const std::vector<int>& gpus : gpu_lists()) {
      FirstSystem<TypeParam> growing(step.scene, *find_cuda(gpus, why));
      const std::vector<Contact<TypeParam>> all = growing.all_contacts();
      for (const std::size_t count : {50, 90, 100, 0, 200, 240, 500}) {
        ASSERT_LE(count, all.size());
        const std::vector<Contact<TypeParam>> some(
            all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
        growing.set_contacts(some);
        FirstSystem<TypeParam> fresh(step.scene, *find_cuda(gpus, why));
        fresh.set_contacts(some);
        expect_same_bits(step.velocities(growing), step.velocities(fresh));
      }
    }
  }
}

}  // namespace
}  // namespace weft::parity
