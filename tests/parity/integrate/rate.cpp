#include "weft/kernels/integrate/rate.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 1000 cloth vertices, behind which come those of obstacles.
template <class T>
struct RateCase {
  using Scalar = T;
  static constexpr Index count = 1000;
  Random random{21};
  std::vector<Vec3<T>> positions = random.vectors<T>(count + 200, -1, 1);
  std::vector<Vec3<T>> base = random.vectors<T>(count, -1, 1);
  T h = T(0.0078125);

  Outputs compute(Device& device, Index parts) const {
    const auto x = upload(device, positions), base_d = upload(device, base);
    const Buffer<Vec3<T>> velocities(device, count);
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(), IntegrateRate<T>{x.span().subspan(b, n), base_d.span().subspan(b, n),
                                                h, velocities.span().subspan(b, n)});
    }
    return {output("velocities", download(velocities))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> rates;
    for (std::size_t v = 0; v < count; ++v) {
      Vec3<double> rate{};
      for (int c = 0; c < 3; ++c)
        rate[c] = (double{positions[v][c]} - double{base[v][c]}) / double{h};
      rates.push_back(rate);
    }
    return {output("velocities", rates)};
  }
};

using Cases = testing::Types<RateCase<float>, RateCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateRate, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
