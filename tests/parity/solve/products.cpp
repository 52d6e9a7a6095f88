#include "weft/kernels/solve/products.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// Rows of a system of 6100 vertices from number 2048 on; the last partial sum is not full.
template <class T, Index partial_rows>
struct ProductsCase {
  using Scalar = T;
  static constexpr Index count = 6100, row_begin = 2048, row_count = 4000;
  static constexpr Index partials = (row_count + partial_rows - 1) / partial_rows;
  Random random{14};
  std::vector<Vec3<T>> residual = random.vectors<T>(row_count, -1, 2);
  std::vector<Vec3<T>> direction = random.vectors<T>(count, -1, 2);
  std::vector<unsigned char> fixed = random.marks(count, 5);

  Outputs compute(Device& device, Index parts) const {
    const auto residual_d = upload(device, residual), direction_d = upload(device, direction);
    const auto fixed_d = upload(device, fixed);
    const Buffer<double> partial(device, 2 * partials);
    for (const auto& [begin, size] : parts_of(row_count, parts, partial_rows)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      const std::size_t first = 2 * b / partial_rows;
      launch(device.compute(),
             SolveProducts<T>{row_begin + begin, size, partial_rows,
                              residual_d.span().subspan(b, n), direction_d.span(), fixed_d.span(),
                              partial.span().subspan(first, partial.size() - first)});
    }
    return {output("partial", download(partial))};
  }

  Outputs reference() const {
    std::vector<double> partial(2 * partials, 0);
    for (std::size_t r = 0; r < row_count; ++r) {
      if (fixed[row_begin + r] != 0) continue;
      for (int c = 0; c < 3; ++c) {
        const double b = double{residual[r][c]};
        partial[2 * (r / partial_rows)] += b * double{direction[row_begin + r][c]};
        partial[2 * (r / partial_rows) + 1] += b * b;
      }
    }
    return {output("partial", partial)};
  }
};

using Cases = testing::Types<ProductsCase<float, 1024>, ProductsCase<float, 8>,
                             ProductsCase<double, 256>, ProductsCase<double, 2048>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveProducts, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
