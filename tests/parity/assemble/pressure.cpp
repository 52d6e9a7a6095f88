#include "weft/kernels/assemble/pressure.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// A crumpled sheet whose triangles bear different pressures, beside forces that are there already.
template <class T>
struct PressureCase {
  using Scalar = T;
  Random random{21};
  Sheet<T> sheet{random};
  std::size_t count = sheet.triangles.size();
  std::vector<T> pressure = random.numbers<T>(count, -100, 100);
  std::vector<Vec3<T>> impulse = random.vectors<T>(3 * count, -0.001, 0.001);
  T h = T(0.0078125);

  Outputs compute(Device& device, Index parts) const {
    const auto triangles_d = upload(device, sheet.triangles);
    const auto pressure_d = upload(device, pressure);
    const auto x = upload(device, sheet.positions);
    const auto impulse_d = upload(device, impulse);
    for (const auto& [begin, size] : parts_of(static_cast<Index>(count), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssemblePressure<T>{triangles_d.span().subspan(b, n), pressure_d.span().subspan(b, n),
                                 x.span(), h, impulse_d.span().subspan(3 * b, 3 * n)});
    }
    return {output("impulse", download(impulse_d))};
  }

  /// Area vectors from the sides at another corner.
  Outputs reference() const {
    std::vector<Vec3<double>> sum;
    for (std::size_t n = 0; n < count; ++n) {
      Vec3<double> x[3];
      for (int c = 0; c < 3; ++c)
        x[c] = vec_cast<double>(sheet.positions[static_cast<std::size_t>(sheet.triangles[n].v[c])]);
      const Vec3<double> area = 0.5 * cross(x[2] - x[1], x[0] - x[1]);
      for (std::size_t c = 0; c < 3; ++c)
        sum.push_back(vec_cast<double>(impulse[3 * n + c]) +
                      (double{h} * double{pressure[n]} / 3) * area);
    }
    return {output("impulse", sum)};
  }
};

using Cases = testing::Types<PressureCase<float>, PressureCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssemblePressure, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
