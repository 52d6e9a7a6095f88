#include "weft/kernels/solve/schwarz_levels.hpp"

#include <Eigen/Dense>

#include "tests/parity/solve/system.hpp"

namespace weft::parity {
namespace {

/// Both levels of a sheet of 2250 rows in partial sums of partial_rows rows, the last domains not
/// whole, one aggregate of each level of fixed vertices only.
template <class T, Index partial_rows, Index slice>
struct LevelsCase {
  using Scalar = T;
  static constexpr FineLevel<T> fine = FineLevel<T>::of(partial_rows);
  static constexpr WideLevel<T> wide = WideLevel<T>::of(partial_rows);
  static constexpr Index row_begin = 1024, rows = 2250 - row_begin;
  SheetSystem system{50, 45, 15};

  LevelsCase() {
    const auto fix = [&](Index first, Index count) {
      for (Index k = first; k < first + count; ++k) system.fixed[SheetSystem::at(k)] = 1;
    };
    fix(row_begin, 64);
    fix(row_begin + 100, 4);
  }

  Outputs compute(Device& device, Index parts) const {
    const auto numbers = [](const auto& level) {
      return level.aggregates == 0
                 ? std::size_t{0}
                 : static_cast<std::size_t>(level.domains(rows) * level.domain_numbers());
    };
    const auto fixed_d = upload(device, system.fixed);
    const Buffer<T> fine_inverse(device, numbers(fine)), wide_inverse(device, numbers(wide));
    const Buffer<double> wide_sum(
        device, static_cast<std::size_t>(fine.domains(rows) * FineLevel<T>::wide_sums));
    const Index step = std::max(fine.domain_rows(), wide.domain_rows());
    for (const auto& [begin, count] : parts_of(rows, parts, step)) {
      const Index first = row_begin + begin, last = first + count;
      const MeshMatrixRows<T> mesh(device, system.mesh, first, last, slice);
      const SlicedRows<T> far(device, system.far, first, last, slice, mesh.order);
      const ContactOperatorRows<T> contact(device, system.links, first, last);
      const auto of_part = [begin](auto level, const Buffer<T>& inverse) {
        if (level.aggregates > 0)
          level.inverse = rest_of(inverse, begin / level.domain_rows() * level.domain_numbers());
        return level;
      };
      launch(device.compute(),
             SolveSchwarzLevels<T>{
                 first, mesh.blocks(), far.scalars(), contact.view(), fixed_d.span(),
                 of_part(fine, fine_inverse), of_part(wide, wide_inverse),
                 rest_of(wide_sum, begin / fine.domain_rows() * FineLevel<T>::wide_sums)});
      device.compute().sync();
    }
    return outputs(dense(download(fine_inverse)), download(wide_inverse));
  }

  Outputs reference() const {
    return outputs(inverses(fine), wide.aggregates > 0 ? inverses(wide) : std::vector<double>{});
  }

 private:
  template <class V>
  static Span<V> rest_of(const Buffer<V>& buffer, Index place) {
    return buffer.span().subspan(static_cast<std::size_t>(place),
                                 buffer.size() - static_cast<std::size_t>(place));
  }
  template <class A, class B>
  static Outputs outputs(const std::vector<A>& fine_inverse, const std::vector<B>& wide_inverse) {
    if (wide_inverse.empty()) return {output("fine", fine_inverse)};
    return {output("fine", fine_inverse), output("wide", wide_inverse)};
  }

  /// Column by column, from products with unit vectors.
  static std::vector<T> dense(const std::vector<T>& blocks) {
    std::vector<T> all;
    for (Index d = 0; d < fine.domains(rows); ++d)
      for (Index k = 0; k < fine.size(); ++k) {
        std::vector<T> x(static_cast<std::size_t>(fine.size()));
        x[static_cast<std::size_t>(k)] = 1;
        for (Index a = 0; a < fine.aggregates; ++a)
          for (const T y : SymmetricBlocks::multiply_row(blocks.data() + d * fine.domain_numbers(),
                                                         fine.aggregates, a, x.data())
                               .e)
            all.push_back(y);
      }
    return all;
  }

  std::vector<double> inverses(const SchwarzLevel<T>& level) const {
    std::vector<double> inverse;
    for (Index d = 0; d < level.domains(rows); ++d) {
      const Index first = row_begin + d * level.domain_rows();
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(level.size(), level.size());
      add(level, system.mesh, first, sum);
      add(level, system.far, first, sum);
      add(level, system.contact, first, sum);
      for (Index k = 0; k < level.size(); ++k)
        if (sum(k, k) == 0) sum(k, k) = 1;
      const Eigen::MatrixXd inverted = sum.inverse();
      for (Index i = 0; i < level.size(); ++i)
        for (Index j = 0; j < level.size(); ++j) inverse.push_back(inverted(i, j));
    }
    return inverse;
  }
  template <class Entry>
  void add(const SchwarzLevel<T>& level, const Rows<Entry>& entries, Index first,
           Eigen::MatrixXd& sum) const {
    const Index last = std::min(system.count, first + level.domain_rows());
    for (Index row = first; row < last; ++row)
      for (const auto& [column, entry] : entries[SheetSystem::at(row)]) {
        if (column < first || column >= last) continue;
        if (system.fixed[SheetSystem::at(row)] + system.fixed[SheetSystem::at(column)] > 0)
          continue;
        const Index i = 3 * ((row - first) >> level.shift);
        const Index j = 3 * ((column - first) >> level.shift);
        for (int p = 0; p < 3; ++p)
          for (int q = 0; q < 3; ++q)
            if constexpr (std::is_arithmetic_v<Entry>)
              sum(i + p, j + q) += p == q ? double{static_cast<T>(entry)} : 0.0;
            else
              sum(i + p, j + q) += double{static_cast<T>(entry(p, q))};
      }
  }
};

using Cases = testing::Types<LevelsCase<float, 1024, 8>, LevelsCase<float, 1024, 32>,
                             LevelsCase<float, 8, 8>, LevelsCase<double, 32, 8>,
                             LevelsCase<double, 128, 8>, LevelsCase<double, 512, 32>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveSchwarzLevels, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
