#include "weft/kernels/solve/galerkin_product.hpp"

#include "tests/parity/solve/coarse_basis.hpp"

namespace weft::parity {
namespace {

/// The units of a sheet of 2,250 rows, the last partial sum and the last unit not whole.
template <class T, Index partial_rows>
struct GalerkinProductCase {
  using Scalar = T;
  CoarseBasisSystem<T, partial_rows> of{50, 45, 15};

  Outputs compute(Device& device, Index parts) const {
    CoarseBasisBuffers<T> modes;
    modes.make(device, of.table, 0, of.system.count);
    for (const auto& [begin, count] : parts_of(of.system.count, parts, partial_rows))
      galerkin_product_rows(device, of, modes, begin, begin + count);
    std::vector<T> inverse(modes.view().fine_inverse.size());
    device.compute().copy(inverse.data(), modes.view().fine_inverse.data(),
                          inverse.size() * sizeof(T));
    device.compute().sync();
    return {output("inverse", inverse)};
  }

  Outputs reference() const {
    return {output("inverse", of.inverses(-1, coarse_dofs * partial_rows /
                                                  coarse_sub_aggregate_rows(partial_rows)))};
  }
};

using Cases = testing::Types<GalerkinProductCase<float, 1024>, GalerkinProductCase<float, 128>,
                             GalerkinProductCase<double, 256>, GalerkinProductCase<double, 1024>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveGalerkinProduct, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
