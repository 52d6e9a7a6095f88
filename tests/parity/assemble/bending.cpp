#include "weft/kernels/assemble/bending.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// A crumpled sheet, every hinge with its own stiffness and rest angle, a third of them undamped.
template <class T, bool with_velocities>
struct BendingCase {
  using Scalar = T;
  Random random{9};
  Sheet<T> sheet{random};
  std::size_t count = sheet.hinges.size();
  std::vector<T> stiffness = random.numbers<T>(count, 1e-4, 2e-4);
  std::vector<T> rest_angle = random.numbers<T>(count, -1, 1);
  std::vector<T> damping = random.numbers<T>(count, 0.001, 0.01);
  std::vector<Vec3<T>> velocities =
      with_velocities ? random.vectors<T>(sheet.positions.size(), -1, 1) : std::vector<Vec3<T>>{};
  T h = T(0.0078125);

  BendingCase() {
    for (std::size_t n = 0; n < count; n += 3) damping[n] = T(0);
  }

  Outputs compute(Device& device, Index parts) const {
    const auto hinges_d = upload(device, sheet.hinges);
    const auto stiffness_d = upload(device, stiffness), rest_d = upload(device, rest_angle);
    const auto damping_d = upload(device, damping);
    const auto x = upload(device, sheet.positions), v = upload(device, velocities);
    const Buffer<Vec3<T>> direction(device, 4 * count);
    const Buffer<T> impulse_scale(device, count), curvature(device, count);
    for (const auto& [begin, size] : parts_of(static_cast<Index>(count), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(
          device.compute(),
          AssembleBending<T>{hinges_d.span().subspan(b, n), stiffness_d.span().subspan(b, n),
                             rest_d.span().subspan(b, n), damping_d.span().subspan(b, n), x.span(),
                             v.span(), h, direction.span().subspan(4 * b, 4 * n),
                             impulse_scale.span().subspan(b, n), curvature.span().subspan(b, n)});
    }
    return {output("direction", download(direction)),
            output("impulse scale", download(impulse_scale)),
            output("curvature", download(curvature))};
  }

  /// Twice the stiffness and the torque by way of the energy's own functions.
  Outputs reference() const {
    std::vector<Vec3<double>> direction;
    std::vector<double> impulse_scale, curvature;
    for (std::size_t n = 0; n < count; ++n) {
      Vec3<double> x[4], g[4], t[4];
      for (int c = 0; c < 4; ++c) x[c] = vec_cast<double>(sheet.positions[corner(n, c)]);
      const double k = hinge_gradient_hessian(x, double{rest_angle[n]}, double{stiffness[n]}, g, t);
      const double theta = hinge_angle(x);
      double rate = 0;
      for (int c = 0; c < 4; ++c) {
        direction.push_back(t[c]);
        if (with_velocities) rate += dot(t[c], vec_cast<double>(velocities[corner(n, c)]));
      }
      const double b = double{damping[n]};
      impulse_scale.push_back(-double{h} * k * (theta - double{rest_angle[n]} + b * rate));
      curvature.push_back(double{h} * (double{h} + b) * k);
    }
    return {output("direction", direction), output("impulse scale", impulse_scale),
            output("curvature", curvature)};
  }
  std::size_t corner(std::size_t n, int c) const {
    return static_cast<std::size_t>(sheet.hinges[n].v[c]);
  }
};

using Cases = testing::Types<BendingCase<float, true>, BendingCase<float, false>,
                             BendingCase<double, true>, BendingCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleBending, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
