#include "weft/kernels/integrate/update.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// Rows 100 to 899 of 1000; the others belong to other ranks and must stay as they are.
template <class T, bool with_iterate>
struct UpdateCase {
  using Scalar = T;
  static constexpr Index count = 1000, row_begin = 100, row_count = 800;
  Random random{2};
  std::vector<Vec3<T>> iterate =
      with_iterate ? random.vectors<T>(count, -3, 3) : std::vector<Vec3<T>>{};
  std::vector<Vec3<T>> dv = random.vectors<T>(count, -3, 3);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -3, 3);
  T share = T(0.375);

  Outputs compute(Device& device, Index parts) const {
    const auto iterate_d = upload(device, iterate), dv_d = upload(device, dv);
    const auto velocities_d = upload(device, velocities);
    for (const auto& [begin, size] : parts_of(row_count, parts))
      launch(device.compute(), IntegrateUpdate<T>{row_begin + begin, size, iterate_d.span(),
                                                  dv_d.span(), share, velocities_d.span()});
    return {output("velocities", download(velocities_d))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> result;
    for (Index v = 0; v < count; ++v) {
      const auto n = static_cast<std::size_t>(v);
      Vec3<double> u = vec_cast<double>(velocities[n]);
      if (v >= row_begin && v < row_begin + row_count)
        for (int c = 0; c < 3; ++c)
          u[c] = (with_iterate ? double{iterate[n][c]} : 0.0) + double{share} * double{dv[n][c]};
      result.push_back(u);
    }
    return {output("velocities", result)};
  }
};

using Cases = testing::Types<UpdateCase<float, true>, UpdateCase<float, false>,
                             UpdateCase<double, true>, UpdateCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateUpdate, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
