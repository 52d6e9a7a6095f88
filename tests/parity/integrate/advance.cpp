#include "weft/kernels/integrate/advance.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

template <class T>
struct AdvanceCase {
  using Scalar = T;
  static constexpr Index count = 1000;      // cloth vertices
  static constexpr Index all_count = 1200;  // and obstacles
  Random random{1};
  std::vector<Vec3<T>> base = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -10, 10);
  std::vector<unsigned char> fixed = random.marks(count, 6);
  std::vector<Vec3<T>> positions = random.vectors<T>(all_count, -1, 1);
  T h = T(0.0078125);

  Outputs compute(Device& device, Index parts) const {
    const auto base_d = upload(device, base), velocities_d = upload(device, velocities);
    const auto fixed_d = upload(device, fixed);
    const auto positions_d = upload(device, positions);
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(
          device.compute(),
          IntegrateAdvance<T>{base_d.span().subspan(b, n), velocities_d.span().subspan(b, n),
                              fixed_d.span().subspan(b, n), h, positions_d.span().subspan(b, n)});
    }
    return {output("positions", download(positions_d))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> result;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      Vec3<double> x = vec_cast<double>(positions[v]);
      if (v < base.size() && fixed[v] == 0)
        for (int c = 0; c < 3; ++c)
          x[c] = double{base[v][c]} + double{h} * double{velocities[v][c]};
      result.push_back(x);
    }
    return {output("positions", result)};
  }
};

using Cases = testing::Types<AdvanceCase<float>, AdvanceCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateAdvance, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
