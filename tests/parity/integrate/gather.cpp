#include "weft/kernels/integrate/gather.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 400 of 1000 vertices in no order, some several times.
template <class T>
struct GatherCase {
  using Scalar = T;
  static constexpr Index count = 1000, chosen = 400;
  Random random{6};
  std::vector<Vec3<T>> values = random.vectors<T>(count, -1, 1);
  std::vector<Index> vertices;

  GatherCase() {
    for (Index i = 0; i < chosen; ++i)
      vertices.push_back(static_cast<Index>(random.uniform<double>(0, count - 1)));
  }

  Outputs compute(Device& device, Index parts) const {
    const auto values_d = upload(device, values);
    const auto vertices_d = upload(device, vertices);
    const Buffer<Vec3<T>> gathered(device, chosen);
    for (const auto& [begin, size] : parts_of(chosen, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(), IntegrateGather<T>{vertices_d.span().subspan(b, n), values_d.span(),
                                                  gathered.span().subspan(b, n)});
    }
    return {output("gathered", download(gathered))};
  }

  Outputs reference() const {
    std::vector<Vec3<T>> gathered;
    for (const Index v : vertices) gathered.push_back(values[static_cast<std::size_t>(v)]);
    return {output("gathered", gathered)};
  }
};

using Cases = testing::Types<GatherCase<float>, GatherCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateGather, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
