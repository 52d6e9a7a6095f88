#include "weft/kernels/assemble/wind.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// A crumpled sheet under way in moving air; one triangle has no area.
template <class T, bool with_velocities>
struct WindCase {
  using Scalar = T;
  Random random{12};
  Sheet<T> sheet{random};
  std::size_t count = sheet.triangles.size();
  std::vector<Vec3<T>> start = random.vectors<T>(sheet.positions.size(), -2, 2);
  std::vector<Vec3<T>> velocities =
      with_velocities ? random.vectors<T>(sheet.positions.size(), -2, 2) : std::vector<Vec3<T>>{};
  std::vector<Vec3<T>> impulse = random.vectors<T>(3 * count, -1e-3, 1e-3);
  std::vector<Mat3<T>> block;
  Vec3<T> wind{T(3), T(-1), T(0.5)};
  T density = T(1.25), drag = T(0.0625), h = T(0.0078125);

  WindCase() {
    sheet.triangles[7].v[1] = sheet.triangles[7].v[0];
    block.resize(6 * count);
    for (Mat3<T>& b : block)
      for (int k = 0; k < 9; ++k) b.e[k] = random.uniform<T>(-1e-4, 1e-4);
  }

  Outputs compute(Device& device, Index parts) const {
    const auto triangles_d = upload(device, sheet.triangles);
    const auto x = upload(device, sheet.positions), start_d = upload(device, start);
    const auto v = upload(device, velocities);
    const auto impulse_d = upload(device, impulse);
    const auto block_d = upload(device, block);
    const Buffer<Mat3<T>> drag_d(device, count);
    for (const auto& [begin, size] : parts_of(static_cast<Index>(count), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssembleWind<T>{triangles_d.span().subspan(b, n), x.span(), start_d.span(), v.span(),
                             density, drag, wind, h, impulse_d.span().subspan(3 * b, 3 * n),
                             block_d.span().subspan(6 * b, 6 * n), drag_d.span().subspan(b, n)});
    }
    return {output("impulse", download(impulse_d)), output("block", download(block_d)),
            output("corner_drag", download(drag_d))};
  }

  /// The force of the relative wind's two parts, and their derivative, one by one.
  Outputs reference() const {
    std::vector<Vec3<double>> impulses;
    std::vector<Mat3<double>> blocks, drags;
    for (std::size_t t = 0; t < count; ++t) {
      Vec3<double> x[3], mean_start{}, mean_now{}, add{};
      for (int c = 0; c < 3; ++c) {
        const auto corner = static_cast<std::size_t>(sheet.triangles[t].v[c]);
        x[c] = vec_cast<double>(sheet.positions[corner]);
        mean_start += (1.0 / 3) * vec_cast<double>(start[corner]);
        if (with_velocities) mean_now += (1.0 / 3) * vec_cast<double>(velocities[corner]);
      }
      const Vec3<double> n = cross(x[1] - x[0], x[2] - x[0]);
      const double twice = length(n);
      Mat3<double> more{};
      if (twice > 0) {
        const Vec3<double> unit = (1 / twice) * n, air = vec_cast<double>(wind);
        const double push = double{density} * std::abs(dot(air - mean_start, unit));
        const Vec3<double> u = air - mean_now, along = dot(u, unit) * unit;
        add = (double{h} * twice / 6) * (push * along + double{drag} * (u - along));
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            more(i, j) =
                double{h} * twice / 18 *
                (push * unit[i] * unit[j] + double{drag} * ((i == j ? 1 : 0) - unit[i] * unit[j]));
      }
      drags.push_back(3 * more);
      for (std::size_t c = 0; c < 3; ++c)
        impulses.push_back(vec_cast<double>(impulse[3 * t + c]) + add);
      for (std::size_t b = 0; b < 6; ++b) {
        Mat3<double> sum = more;
        for (int k = 0; k < 9; ++k) sum.e[k] += double{block[6 * t + b].e[k]};
        blocks.push_back(sum);
      }
    }
    return {output("impulse", impulses), output("block", blocks), output("corner_drag", drags)};
  }
};

using Cases = testing::Types<WindCase<float, true>, WindCase<float, false>, WindCase<double, true>,
                             WindCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleWind, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
