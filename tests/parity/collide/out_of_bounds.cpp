#include "weft/kernels/collide/out_of_bounds.hpp"

#include <cmath>

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// Vertices of which some start or end outside their boxes, or nowhere.
template <class T>
struct OutOfBoundsCase {
  using Scalar = T;
  static constexpr Index vertices = 3000;
  Random random{34};
  std::vector<Vec3<T>> positions_t0 = random.vectors<T>(vertices, -1.02, 1.02);
  std::vector<Vec3<T>> positions_t1 = random.vectors<T>(vertices, -1.02, 1.02);
  std::vector<BoxOf<T>> boxes{vertices, BoxOf<T>{{-1, -1, -1}, {1, 1, 1}}};

  OutOfBoundsCase() {
    positions_t1[7][1] = std::numeric_limits<T>::quiet_NaN();
    positions_t0[8] = positions_t1[8] = {1, -1, 1};  // on the box counts as inside
  }

  /// In parts, whose counts are summed: the sum does not depend on them.
  Outputs compute(Device& device, Index parts) const {
    const auto x0 = upload(device, positions_t0), x1 = upload(device, positions_t1);
    const auto box = upload(device, boxes);
    std::vector<Index> out_of_bounds;
    for (const bool is_split : {false, true}) {
      const auto split = upload(device, std::vector<unsigned char>(1, is_split ? 1 : 0));
      out_of_bounds.push_back(0);
      for (const auto& [begin, size] : parts_of(vertices, parts)) {
        CollideCounts before;
        before.face_pairs = 11;
        before.out_of_bounds = -5;
        const auto counts = upload(device, std::vector<CollideCounts>{before});
        launch(device.compute(), CollideOutOfBounds<T>{x0.span(), x1.span(), box.span(), begin,
                                                       begin + size, counts.span(), split.span()});
        const CollideCounts after = download(counts).front();
        EXPECT_EQ(after.face_pairs, 11);
        out_of_bounds.back() += after.out_of_bounds;
      }
    }
    return {output("escaped", out_of_bounds)};
  }

  Outputs reference() const {
    Index out_of_bounds = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
      bool inside = true;
      for (const auto* x : {&positions_t0[v], &positions_t1[v]})
        for (const T along : x->e) inside = inside && std::abs(along) <= T(1);
      out_of_bounds += inside ? 0 : 1;
    }
    return {
        output("escaped", std::vector<Index>{out_of_bounds, vertices})};  // all, of a split motion
  }
};

using Cases = testing::Types<OutOfBoundsCase<float>, OutOfBoundsCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(CollideOutOfBounds, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
