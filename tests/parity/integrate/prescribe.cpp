#include "weft/kernels/integrate/prescribe.hpp"

#include <numeric>

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 400 of 1000 vertices have a target, each one, in no order.
template <class T>
struct PrescribeCase {
  using Scalar = T;
  static constexpr Index count = 1000, target_count = 400;
  Random random{5};
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<MovedVertex<T>> targets;

  PrescribeCase() {
    std::vector<Index> order(count);
    std::iota(order.begin(), order.end(), 0);
    random.shuffle(order);
    for (std::size_t i = 0; i < target_count; ++i)
      targets.push_back({order[i], random.vector<T>(-1, 1)});
  }

  Outputs compute(Device& device, Index parts) const {
    const auto x = upload(device, positions);
    const auto targets_d = upload(device, targets);
    for (const auto& [begin, size] : parts_of(target_count, parts))
      launch(device.compute(),
             IntegratePrescribe<T>{targets_d.span().subspan(static_cast<std::size_t>(begin),
                                                            static_cast<std::size_t>(size)),
                                   x.span()});
    return {output("positions", download(x))};
  }

  Outputs reference() const {
    std::vector<Vec3<T>> x = positions;
    for (const MovedVertex<T>& m : targets) x[static_cast<std::size_t>(m.vertex)] = m.position;
    return {output("positions", x)};
  }
};

using Cases = testing::Types<PrescribeCase<float>, PrescribeCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegratePrescribe, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
