#include "weft/kernels/integrate/step_error.hpp"

#include <cmath>
#include <limits>

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 10,000 cloth vertices, behind which come those of obstacles. Components of all sizes: some are
/// smaller than a warp, one spans many blocks. Some vertices are held, some are off by more than
/// the most that counts.
template <class T>
struct StepErrorCase {
  using Scalar = T;
  static constexpr Index count = 10'000, components = 40;
  Random random{31};
  std::vector<Vec3<T>> x0 = random.vectors<T>(count + 200, -1, 1);
  std::vector<Vec3<T>> v0 = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> x1 = x0;
  std::vector<Vec3<T>> v1 = v0;
  std::vector<unsigned char> fixed = random.marks(count + 200, 7);
  std::vector<Index> component;
  double dt = 0.0078125;
  double inverse_tolerance = 2000;

  StepErrorCase() {
    for (Index v = 0; v < count; ++v) {
      const auto n = static_cast<std::size_t>(v);
      component.push_back(v < 400 ? v / 10 % (components - 1) : components - 1);
      v1[n] += random.vector<T>(-0.3, 0.3);
      x1[n] += random.vector<T>(-0.002, 0.002);
      if (v % 100 == 99) x1[n] += random.vector<T>(-1, 1);
    }
    v1[17][1] = std::numeric_limits<T>::quiet_NaN();
    fixed[17] = 0;
  }

  Outputs compute(Device& device, Index parts) const {
    const auto a = upload(device, x0), b = upload(device, v0), c = upload(device, x1),
               d = upload(device, v1);
    const auto held = upload(device, fixed);
    const auto of_vertex = upload(device, component);
    const Buffer<std::int64_t> sums =
        upload(device, std::vector<std::int64_t>(std::size_t{2} * components, 0));
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto o = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             IntegrateStepError<T>{a.span().subspan(o, n), b.span().subspan(o, n),
                                   c.span().subspan(o, n), d.span().subspan(o, n),
                                   held.span().subspan(o, n), of_vertex.span().subspan(o, n), dt,
                                   inverse_tolerance, sums.span()});
    }
    return separate(download(sums));
  }

  Outputs reference() const {
    std::vector<double> squares(components), free(components);
    for (std::size_t v = 0; v < count; ++v) {
      if (fixed[v] != 0) continue;
      double sq = 0;
      for (int k = 0; k < 3; ++k) {
        const double end = double{x0[v][k]} + dt * (double{v0[v][k]} + double{v1[v][k]}) / 2;
        sq += std::pow((double{x1[v][k]} - end) * inverse_tolerance, 2);
      }
      const auto c = static_cast<std::size_t>(component[v]);
      squares[c] += std::isnan(sq) ? 4096 : std::min(sq, 4096.0);
      free[c] += 1;
    }
    return {output("squares", squares), output("free vertices", free)};
  }

 private:
  static Outputs separate(const std::vector<std::int64_t>& sums) {
    std::vector<double> squares, free;
    for (std::size_t c = 0; c < components; ++c) {
      squares.push_back(static_cast<double>(sums[2 * c]) / step_error_one);
      free.push_back(static_cast<double>(sums[2 * c + 1]));
    }
    return {output("squares", squares), output("free vertices", free)};
  }
};

using Cases = testing::Types<StepErrorCase<float>, StepErrorCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(IntegrateStepError, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
