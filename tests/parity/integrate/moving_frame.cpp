#include "weft/kernels/integrate/moving_frame.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 1000 vertices of three pieces.
template <class T>
struct MovingFrameCase {
  using Scalar = T;
  static constexpr Index count = 1000;
  static constexpr Index pieces = 3;
  Random random{23};
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -10, 10);
  std::vector<Index> component_of_vertex = numbers(count, 7, pieces);
  std::vector<Index> sample = numbers(pieces * moving_frame_samples, 389, count);
  T dt = T(0.0078125);

  /// `count` numbers below `limit`, not in order.
  static std::vector<Index> numbers(Index count, Index stride, Index limit) {
    std::vector<Index> all;
    for (Index k = 0; k < count; ++k) all.push_back(k * stride % limit);
    return all;
  }

  Outputs compute(Device& device, Index parts) const {
    const auto x = upload(device, positions), v = upload(device, velocities);
    const auto piece = upload(device, component_of_vertex), sample_d = upload(device, sample);
    const Buffer<Vec3<T>> moved(device, count), drift(device, count);
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             IntegrateMovingFrame<T>{x.span().subspan(b, n), v.span(), piece.span().subspan(b, n),
                                     sample_d.span(), dt, moved.span().subspan(b, n),
                                     drift.span().subspan(b, n)});
    }
    return {output("positions", download(moved)), output("velocities", download(drift))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> moved, drift;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      Vec3<double> mean{};
      for (int k = 0; k < moving_frame_samples; ++k)
        mean +=
            (1.0 / moving_frame_samples) *
            vec_cast<double>(velocities[static_cast<std::size_t>(sample[static_cast<std::size_t>(
                component_of_vertex[v] * moving_frame_samples + k)])]);
      drift.push_back(mean);
      moved.push_back(vec_cast<double>(positions[v]) + double{dt} * mean);
    }
    return {output("positions", moved), output("velocities", drift)};
  }
};

using Cases = testing::Types<MovingFrameCase<float>, MovingFrameCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateMovingFrame, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
