#include "weft/kernels/solve/coarse_inverse.hpp"

#include "tests/parity/solve/coarse_basis.hpp"

namespace weft::parity {
namespace {

/// All levels above partial sums of a sheet: two to three of them, whose last domains are not
/// whole. Strips go in as SolveProject makes them.
template <class T, Index partial_rows, Index up>
struct UpperCase {
  using Scalar = T;
  ModeSystem<T, partial_rows> of{50, up, 16};

  Outputs compute(Device& device, Index parts) const {
    ModeBuffers<T> modes;
    modes.make(device, of.table, 0, of.system.count);
    for (const auto& [begin, count] : parts_of(of.system.count, parts, partial_rows))
      project_rows(device, of, modes, begin, begin + count);
    modes.launch_upper(device.compute());
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
      all.push_back(output("level " + std::to_string(level), of.inverses(level, mode_size)));
    return all;
  }
};

using Cases = testing::Types<UpperCase<float, 1024, 45>, UpperCase<float, 64, 45>,
                             UpperCase<double, 8, 48>, UpperCase<double, 1, 10>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveUpper, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
