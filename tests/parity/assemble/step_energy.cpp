#include "weft/kernels/assemble/step_energy.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// Rows of a system of 6100 vertices from number 2048 on, with elements around them at random; the
/// last partial sum is not full.
template <class T, Index partial_rows>
struct StepEnergyCase {
  using Scalar = T;
  static constexpr Index count = 6100, row_begin = 2048, row_count = 4000, triangles = 900;
  static constexpr Index partials = (row_count + partial_rows - 1) / partial_rows;
  Random random{31};
  std::vector<T> mass = random.numbers<T>(count, 0.1, 0.2);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -1, 2);
  std::vector<StretchError<T>> error;
  std::vector<Offset> offset{0};
  std::vector<Index> source;

  StepEnergyCase() {
    for (Index n = 0; n < triangles; ++n)
      error.push_back({random.uniform<T>(0, 1), random.uniform<T>(0, 2), random.uniform<T>(0, 3)});
    for (Index row = 0; row < row_count; ++row) {
      for (Index k = 0; k < row % 7; ++k) {
        const auto corner = static_cast<Index>(random.uniform<double>(0, 3 * triangles));
        source.push_back(k == 5 ? -1 - corner : corner);
      }
      offset.push_back(static_cast<Offset>(source.size()));
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto mass_d = upload(device, mass);
    const auto velocities_d = upload(device, velocities);
    const auto error_d = upload(device, error);
    const auto offset_d = upload(device, offset);
    const auto source_d = upload(device, source);
    const Buffer<double> partial(device, 3 * partials);
    for (const auto& [begin, size] : parts_of(row_count, parts, partial_rows)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      const std::size_t first = 3 * b / partial_rows;
      launch(device.compute(),
             AssembleStepEnergy<T>{row_begin + begin, size, partial_rows, mass_d.span(),
                                   velocities_d.span(), offset_d.span().subspan(b, n + 1),
                                   source_d.span(), error_d.span(),
                                   partial.span().subspan(first, partial.size() - first)});
    }
    return {output("partial", download(partial))};
  }

  Outputs reference() const {
    std::vector<double> partial(3 * partials, 0);
    for (std::size_t row = 0; row < row_count; ++row) {
      double* sum = partial.data() + 3 * (row / partial_rows);
      for (int c = 0; c < 3; ++c)
        sum[0] += double{mass[row_begin + row]} / 2 * double{velocities[row_begin + row][c]} *
                  double{velocities[row_begin + row][c]};
      for (auto k = static_cast<std::size_t>(offset[row]);
           k < static_cast<std::size_t>(offset[row + 1]); ++k) {
        if (source[k] < 0) continue;
        const StretchError<T>& e = error[static_cast<std::size_t>(source[k]) / 3];
        sum[0] += double{e.elastic} / 3;
        sum[1] += double{e.turned} / 3;
        sum[2] += double{e.limited} / 3;
      }
    }
    return {output("partial", partial)};
  }
};

using Cases = testing::Types<StepEnergyCase<float, 1024>, StepEnergyCase<float, 8>,
                             StepEnergyCase<double, 256>, StepEnergyCase<double, 2048>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleStepEnergy, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
