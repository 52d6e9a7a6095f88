#include "weft/kernels/assemble/stretch_error.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/parity/assemble/turned_triangle.hpp"
#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// Energy of one side of a limit at a principal strain, and its first two derivatives, from the
/// formulas of elements/strain_limit.hpp.
struct PlainLimit {
  double half, stiffness;

  double curvature(double g) const {
    const double y = std::clamp(g / half - 1, 0.0, 1.0);
    return stiffness * y * y;
  }
  double slope(double g) const {
    return integrate(g, [&](double s) { return curvature(s); });
  }
  double energy(double g) const {
    return integrate(g, [&](double s) { return slope(s); });
  }

 private:
  /// From where the limit begins, in two pieces between which the curvature has a kink, each by
  /// Gauss-Legendre of order 8, which is exact for them.
  template <class Function>
  double integrate(double g, Function f) const {
    const double kink = std::abs(g) > std::abs(2 * half) ? 2 * half : g;
    return gauss(half, kink, f) + gauss(kink, g, f);
  }
  template <class Function>
  static double gauss(double from, double to, Function f) {
    constexpr double at[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                             0.9602898564975363};
    constexpr double weight[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                 0.1012285362903763};
    const double middle = (from + to) / 2, radius = (to - from) / 2;
    double sum = 0;
    for (int k = 0; k < 4; ++k)
      sum += weight[k] * (f(middle + radius * at[k]) + f(middle - radius * at[k]));
    return radius * sum;
  }
};

/// A crumpled sheet of a material of each kind that moves somewhat.
/// @tparam turns triangles turn before
template <class T, bool turns = false>
struct StretchErrorCase {
  using Scalar = T;
  static constexpr double least = 0.9375, most = 1.0625, limit_stiffness = 4096;
  Random random{21};
  Sheet<T> sheet{random};
  std::size_t count = sheet.triangles.size();
  std::vector<Vec3<T>> moved = sheet.positions;
  std::vector<Mat2<T>> inv_rest;
  std::vector<T> area = random.numbers<T>(count, 0.004, 0.006);
  std::vector<Index> material;
  std::vector<MaterialRow<T>> materials = {
      {{T(400), T(300)}, T(0)},
      {{T(400), T(300)}, T(0), MembraneKind::orthotropic, {T(500), T(90), T(200), T(80)}},
      {{T(400), T(300)},
       T(0),
       MembraneKind::orthotropic,
       {T(200), T(90), T(500), T(80)},
       0,
       membrane_limits(T(least), T(most), T(limit_stiffness))}};

  std::vector<Vec3<T>> velocities =
      turns ? random.vectors<T>(sheet.positions.size(), -2, 2) : std::vector<Vec3<T>>{};
  T dt = T(0.0078125);

  StretchErrorCase() {
    for (MaterialRow<T>& m : materials) m.density = T(0.25);
    for (Vec3<T>& x : moved) x += random.vector<T>(-0.01, 0.01);
    for (std::size_t n = 0; n < count; ++n) {
      const double e = random.uniform<double>(9, 11), f = random.uniform<double>(9, 11);
      const double skew = n % 2 == 0 ? -e : 0;
      const double other = n % 2 == 0 ? 0 : -f;
      inv_rest.push_back({{static_cast<T>(static_cast<float>(e)), static_cast<T>(skew),
                           static_cast<T>(other), static_cast<T>(static_cast<float>(f))}});
      material.push_back(static_cast<Index>(n % materials.size()));
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto triangles_d = upload(device, sheet.triangles);
    const auto inv_rest_d = upload(device, inv_rest);
    const auto area_d = upload(device, area);
    const auto material_d = upload(device, material);
    const auto materials_d = upload(device, materials);
    const auto x0 = upload(device, sheet.positions), x1 = upload(device, moved);
    const auto v = upload(device, velocities);
    const Buffer<StretchError<T>> error(device, count);
    for (const auto& [begin, size] : parts_of(static_cast<Index>(count), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssembleStretchError<T>{
                 triangles_d.span().subspan(b, n),
                 inv_rest_d.span().subspan(b, n),
                 area_d.span().subspan(b, n),
                 material_d.span().subspan(b, n),
                 materials_d.span(),
                 x0.span(),
                 x1.span(),
                 error.span().subspan(b, n),
                 {},
                 turns ? TurnedStart<T>{x0.span(), v.span(), dt} : TurnedStart<T>{}});
    }
    return numbers(download(error));
  }
  template <class U>
  static Outputs numbers(const std::vector<StretchError<U>>& all) {
    Outputs out = {{"elastic", {}}, {"turned", {}}, {"limited", {}}, {"crosses a limit", {}}};
    for (const StretchError<U>& e : all) {
      out[0].values.push_back(static_cast<double>(e.elastic));
      out[1].values.push_back(static_cast<double>(e.turned));
      const bool crosses = std::isinf(e.limited);
      out[2].values.push_back(crosses ? 0 : static_cast<double>(e.limited));
      out[3].values.push_back(crosses ? 1 : 0);
    }
    return out;
  }

  using Gradient = Eigen::Matrix<double, 3, 2>;
  Gradient gradient(std::size_t n, const std::vector<Vec3<T>>& x) const {
    Gradient edges;
    Eigen::Matrix2d inverse;
    for (int k = 0; k < 2; ++k)
      for (int c = 0; c < 3; ++c)
        edges(c, k) = double{x[static_cast<std::size_t>(sheet.triangles[n].v[k + 1])][c]} -
                      double{x[static_cast<std::size_t>(sheet.triangles[n].v[0])][c]};
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 2; ++c) inverse(r, c) = double{inv_rest[n](r, c)};
    return edges * inverse;
  }
  static Eigen::Matrix2d green(const Gradient& f) {
    return (f.transpose() * f - Eigen::Matrix2d::Identity()) / 2;
  }
  static PlainLimit limit(double strain) {
    const double stretch = strain > 0 ? most : least;
    return {(stretch * stretch - 1) / 4, limit_stiffness};
  }

  Outputs reference() const {
    std::vector<StretchError<double>> all;
    constexpr double stiffness[] = {1000, 500, 500};
    for (std::size_t n = 0; n < count; ++n) {
      const double k = stiffness[n % 3];
      const Gradient before = gradient(n, sheet.positions), after = gradient(n, moved);
      Gradient change = after - before;
      if (turns) {
        double speed_sq = 0;
        for (const Index corner : sheet.triangles[n].v)
          speed_sq += length_sq(vec_cast<double>(velocities[static_cast<std::size_t>(corner)]));
        change = after - turned_columns(before, double{dt} * gradient(n, velocities),
                                        0.03 * 0.25 / 6 * speed_sq, k / 8);
      }
      const double a = double{area[n]};
      StretchError<double> e{a * k / 2 * green(before).squaredNorm(),
                             a * k / 8 * (change.transpose() * change).squaredNorm(), 0};
      if (n % 3 == 2) {
        const Eigen::Vector2d from = green(before).selfadjointView<Eigen::Upper>().eigenvalues();
        const Eigen::Vector2d to = green(after).selfadjointView<Eigen::Upper>().eigenvalues();
        const auto within = [](const Eigen::Vector2d& g) {
          return 2 * g[0] >= least * least - 1 && 2 * g[1] <= most * most - 1;
        };
        const bool crosses = within(from) && !within(to);
        for (int j = 0; j < 2; ++j) {
          const PlainLimit l = limit(from[j]);
          const double d = to[j] - from[j];
          e.elastic += a * l.energy(from[j]);
          e.limited += a * std::abs(limit(to[j]).energy(to[j]) - l.energy(from[j]) -
                                    l.slope(from[j]) * d - l.curvature(from[j]) * d * d / 2);
        }
        if (crosses) e.limited = std::numeric_limits<double>::infinity();
      }
      all.push_back(e);
    }
    return numbers(all);
  }
};

using Cases = testing::Types<StretchErrorCase<float>, StretchErrorCase<double>,
                             StretchErrorCase<float, true>, StretchErrorCase<double, true>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleStretchError, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
