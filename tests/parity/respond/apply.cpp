#include "weft/kernels/respond/apply.hpp"

#include <numeric>

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 600 of 1000 vertices move, each once, in no order.
template <class T>
struct ApplyCase {
  using Scalar = T;
  static constexpr Index count = 1000, moved_count = 600;
  Random random{4};
  std::vector<Vec3<T>> base = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> velocities = random.vectors<T>(count, -50, 50);
  std::vector<unsigned char> moved_now = std::vector<unsigned char>(count, 0);
  std::vector<unsigned char> touched = random.marks(count, 4);
  std::vector<MovedVertex<T>> moved;
  T h = T(0.03125);

  ApplyCase() {
    std::vector<Index> order(count);
    std::iota(order.begin(), order.end(), 0);
    random.shuffle(order);
    for (std::size_t i = 0; i < moved_count; ++i)
      moved.push_back({order[i], random.vector<T>(-1, 1)});
  }

  Outputs compute(Device& device, Index parts) const {
    const auto base_d = upload(device, base), x = upload(device, positions);
    const auto v = upload(device, velocities);
    const auto now = upload(device, moved_now), step = upload(device, touched);
    const auto moved_d = upload(device, moved);
    for (const auto& [begin, size] : parts_of(moved_count, parts))
      launch(device.compute(),
             RespondApply<T>{moved_d.span().subspan(static_cast<std::size_t>(begin),
                                                    static_cast<std::size_t>(size)),
                             base_d.span(), h, x.span(), v.span(), now.span(), step.span()});
    return {output("positions", download(x)), output("velocities", download(v)),
            output("moved now", download(now)), output("touched", download(step))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> x, v;
    for (const Vec3<T>& p : positions) x.push_back(vec_cast<double>(p));
    for (const Vec3<T>& u : velocities) v.push_back(vec_cast<double>(u));
    std::vector<unsigned char> now = moved_now, step = touched;
    for (const MovedVertex<T>& m : moved) {
      const auto n = static_cast<std::size_t>(m.vertex);
      x[n] = vec_cast<double>(m.position);
      for (int c = 0; c < 3; ++c) v[n][c] = (x[n][c] - double{base[n][c]}) / double{h};
      now[n] = step[n] = 1;
    }
    return {output("positions", x), output("velocities", v), output("moved now", now),
            output("touched", step)};
  }
};

using Cases = testing::Types<ApplyCase<float>, ApplyCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(RespondApply, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
