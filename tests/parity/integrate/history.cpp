#include "weft/kernels/integrate/history.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

template <class T>
struct HistoryCase {
  using Scalar = T;
  static constexpr Index count = 1000;
  Random random{3};
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -5, 5);
  std::vector<Vec3<T>> previous_positions = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> previous_velocities = random.vectors<T>(count, -5, 5);
  std::vector<unsigned char> touched = random.marks(count, 5);  ///< 1: in the last step
  T ratio = T(0.5);
  T previous_step = T(0.0625);

  Outputs compute(Device& device, Index parts) const {
    const auto x = upload(device, positions), v = upload(device, velocities);
    const auto x0 = upload(device, previous_positions), v0 = upload(device, previous_velocities);
    std::vector<unsigned char> bytes;
    for (std::size_t n = 0; n < touched.size(); ++n)
      bytes.push_back(static_cast<unsigned char>(128 * touched[n] + n % 57));
    const auto touched_d = upload(device, bytes);
    const Buffer<Vec3<T>> base_x(device, count), base_v(device, count);
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             IntegrateHistory<T>{x.span().subspan(b, n), v.span().subspan(b, n),
                                 x0.span().subspan(b, n), v0.span().subspan(b, n),
                                 touched_d.span().subspan(b, n), ratio, previous_step,
                                 base_x.span().subspan(b, n), base_v.span().subspan(b, n)});
    }
    return {output("base positions", download(base_x)),
            output("base velocities", download(base_v))};
  }

  /// The two-step formula as it stands in the books, not the kernel's form by differences.
  Outputs reference() const {
    const double q = ratio;
    const double c0 = (1 + 2 * q) / (1 + q);
    std::vector<Vec3<double>> base_x, base_v;
    for (std::size_t n = 0; n < positions.size(); ++n) {
      const Vec3<double> x1 = vec_cast<double>(positions[n]), v1 = vec_cast<double>(velocities[n]);
      Vec3<double> x0 = vec_cast<double>(previous_positions[n]);
      Vec3<double> v0 = vec_cast<double>(previous_velocities[n]);
      if (touched[n] != 0) {
        x0 = x1 - double{previous_step} * v1;
        v0 = v1;
      }
      base_x.push_back((1 / c0) * ((1 + q) * x1 - (q * q / (1 + q)) * x0));
      base_v.push_back((1 / c0) * ((1 + q) * v1 - (q * q / (1 + q)) * v0));
    }
    return {output("base positions", base_x), output("base velocities", base_v)};
  }
};

using Cases = testing::Types<HistoryCase<float>, HistoryCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateHistory, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
