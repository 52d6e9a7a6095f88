#include "weft/kernels/integrate/apply_forces.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

template <class T>
struct ApplyForcesCase {
  using Scalar = T;
  static constexpr Index count = 700;
  Random random{8};
  std::vector<Vec3<T>> accelerations = random.vectors<T>(count, -50, 50);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -10, 10);
  T h = T(0.0078125);

  Outputs compute(Device& device, Index parts) const {
    const auto accelerations_d = upload(device, accelerations);
    const auto velocities_d = upload(device, velocities);
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(), IntegrateApplyForces<T>{accelerations_d.span().subspan(b, n), h,
                                                       velocities_d.span().subspan(b, n)});
    }
    return {output("velocities", download(velocities_d))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> result;
    for (std::size_t v = 0; v < velocities.size(); ++v) {
      Vec3<double> sum = vec_cast<double>(velocities[v]);
      for (int c = 0; c < 3; ++c) sum[c] += double{h} * double{accelerations[v][c]};
      result.push_back(sum);
    }
    return {output("velocities", result)};
  }
};

using Cases = testing::Types<ApplyForcesCase<float>, ApplyForcesCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateApplyForces, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
