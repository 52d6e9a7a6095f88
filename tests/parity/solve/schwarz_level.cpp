#include "weft/kernels/solve/schwarz_level.hpp"

#include <Eigen/Dense>

#include "tests/parity/solve/system.hpp"

namespace weft::parity {
namespace {

/// Level 0 or 1 of a sheet of 2250 rows in partial sums of partial_rows rows, the last domain not
/// whole, one aggregate of fixed vertices only.
template <class T, int level, Index partial_rows, Index slice>
struct CoarseCase {
  using Scalar = T;
  static constexpr Index aggregates = schwarz_aggregates(level, partial_rows);
  static constexpr Index domain_rows = aggregates << schwarz_shift(level), size = 3 * aggregates;
  SheetSystem system{50, 45, 15};
  static constexpr Index row_begin = 1024, domains = (2250 - 1024 + domain_rows - 1) / domain_rows;

  CoarseCase() {
    for (std::size_t k = 0; k < std::size_t{1} << schwarz_shift(level); ++k)
      system.fixed[static_cast<std::size_t>(row_begin) + k] = 1;
  }

  Outputs compute(Device& device, Index parts) const {
    const auto fixed_d = upload(device, system.fixed);
    const Buffer<T> inverse(device, static_cast<std::size_t>(domains * size * size));
    for (const auto& [begin, count] : parts_of(system.count - row_begin, parts, domain_rows)) {
      const Index first = row_begin + begin, last = first + count;
      const MeshMatrixRows<T> mesh(device, system.mesh, first, last, slice);
      const SlicedRows<T> far(device, system.far, first, last, slice);
      const ContactOperatorRows<T> contact(device, system.links, first, last);
      const auto place = static_cast<std::size_t>(begin / domain_rows * size * size);
      launch(device.compute(),
             SolveSchwarzLevel<T>{
                 first, mesh.blocks(), far.scalars(), contact.view(), fixed_d.span(),
                 SchwarzLevel<T>{schwarz_shift(level), aggregates,
                                 inverse.span().subspan(place, inverse.size() - place)}});
      device.compute().sync();
    }
    return {output("inverse", download(inverse))};
  }

  Outputs reference() const {
    std::vector<double> inverse;
    for (Index d = 0; d < domains; ++d) {
      const Index first = row_begin + d * domain_rows;
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
      add(system.mesh, first, sum);
      add(system.far, first, sum);
      add(system.contact, first, sum);
      for (Index k = 0; k < size; ++k)
        if (sum(k, k) == 0) sum(k, k) = 1;
      const Eigen::MatrixXd inverted = sum.inverse();
      for (Index i = 0; i < size; ++i)
        for (Index j = 0; j < size; ++j) inverse.push_back(inverted(i, j));
    }
    return {output("inverse", inverse)};
  }
  template <class Entry>
  void add(const Rows<Entry>& rows, Index first, Eigen::MatrixXd& sum) const {
    const Index last = std::min(system.count, first + domain_rows);
    for (Index row = first; row < last; ++row)
      for (const auto& [column, entry] : rows[static_cast<std::size_t>(row)]) {
        if (column < first || column >= last) continue;
        if (system.fixed[SheetSystem::at(row)] + system.fixed[SheetSystem::at(column)] > 0)
          continue;
        const Index i = 3 * ((row - first) >> schwarz_shift(level));
        const Index j = 3 * ((column - first) >> schwarz_shift(level));
        for (int p = 0; p < 3; ++p)
          for (int q = 0; q < 3; ++q)
            if constexpr (std::is_arithmetic_v<Entry>)
              sum(i + p, j + q) += p == q ? double{static_cast<T>(entry)} : 0.0;
            else
              sum(i + p, j + q) += double{static_cast<T>(entry(p, q))};
      }
  }
};

using Cases = testing::Types<CoarseCase<float, 0, 1024, 8>, CoarseCase<float, 1, 1024, 32>,
                             CoarseCase<float, 0, 8, 8>, CoarseCase<double, 0, 32, 8>,
                             CoarseCase<double, 1, 128, 8>, CoarseCase<double, 1, 512, 32>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveSchwarzLevel, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
