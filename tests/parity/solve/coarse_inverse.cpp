#include "weft/kernels/solve/coarse_inverse.hpp"

#include "tests/parity/solve/coarse_basis.hpp"

namespace weft::parity {
namespace {

/// All levels above partial sums of a sheet: two to three of them, whose last domains are not
/// whole. Strips go in as SolveGalerkinProduct makes them.
template <class T, Index partial_rows, Index up>
struct CoarseInverseCase {
  using Scalar = T;
  CoarseBasisSystem<T, partial_rows> of{50, up, 16};

  Outputs compute(Device& device, Index parts) const {
    CoarseBasisBuffers<T> modes;
    modes.make(device, of.table, 0, of.system.count);
    for (const auto& [begin, count] : parts_of(of.system.count, parts, partial_rows))
      galerkin_product_rows(device, of, modes, begin, begin + count);
    modes.launch_coarse_inverse(device.compute());
    device.compute().sync();
    Outputs all;
    for (int level = 0; level < of.upper_count(); ++level) {
      const Span<T> on_device = modes.view().upper[level].inverse;
      std::vector<T> inverse(on_device.size());
      device.compute().copy(inverse.data(), on_device.data(), inverse.size() * sizeof(T));
      device.compute().sync();
      all.push_back(output("level " + std::to_string(level), inverse));
    }
    return all;
  }

  Outputs reference() const {
    Outputs all;
    for (int level = 0; level < of.upper_count(); ++level)
      all.push_back(
          output("level " + std::to_string(level), of.inverses(level, coarse_domain_dofs)));
    return all;
  }
};

using Cases = testing::Types<CoarseInverseCase<float, 1024, 45>, CoarseInverseCase<float, 64, 45>,
                             CoarseInverseCase<double, 8, 48>, CoarseInverseCase<double, 1, 10>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveCoarseInverse, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
