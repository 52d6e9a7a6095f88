#include "weft/kernels/integrate/world_positions.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 1500 inputs, some of which are one of 1000 vertices, far from the world's middle.
template <class T>
struct WorldPositionsCase {
  using Scalar = T;
  static constexpr Index count = 1000, inputs = 1500;
  Random random{9};
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<Index> vertices;
  Vec3<double> origin{4096, -12.5, 300000.25};

  WorldPositionsCase() {
    for (Index i = 0; i < inputs; ++i)
      vertices.push_back(static_cast<Index>(random.uniform<double>(0, count - 1)));
  }

  Outputs compute(Device& device, Index parts) const {
    const auto positions_d = upload(device, positions);
    const auto vertices_d = upload(device, vertices);
    const Buffer<Vec3<float>> world(device, inputs);
    for (const auto& [begin, size] : parts_of(inputs, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             IntegrateWorldPositions<T>{vertices_d.span().subspan(b, n), positions_d.span(), origin,
                                        world.span().subspan(b, n)});
    }
    return {output("world", download(world))};
  }

  Outputs reference() const {
    std::vector<Vec3<float>> world;
    for (const Index v : vertices) {
      const Vec3<T>& x = positions[static_cast<std::size_t>(v)];
      Vec3<float> sum;
      for (int c = 0; c < 3; ++c) sum[c] = static_cast<float>(double{x[c]} + origin[c]);
      world.push_back(sum);
    }
    return {output("world", world)};
  }
};

using Cases = testing::Types<WorldPositionsCase<float>, WorldPositionsCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateWorldPositions, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
