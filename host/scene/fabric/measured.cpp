#include "host/scene/fabric/measured.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "weft/elements/membrane_measured.hpp"

namespace weft {
namespace {

using Samples = MembraneSamples<double>;
using Ridges = MembraneRidges<double>;
using Strain = detail::Symmetric2<double>;
using Coefficients = std::array<double, 4>;

Coefficients blended(const Coefficients& a, const Coefficients& b, double share) {
  Coefficients c{};
  for (std::size_t k = 0; k < 4; ++k) c[k] = (1 - share) * a[k] + share * b[k];
  return c;
}

Coefficients evaluate(const MeasuredStretch& measured, const Strain& g) {
  // Eigenvalues of 2 G + I.
  const double mean = 1 + g.xx + g.yy;
  const double half = g.xx - g.yy;
  const double radius = std::hypot(half, 2 * g.xy);
  const double stretch = std::sqrt(std::max(mean + radius, 0.0));
  // The eigenvector of the larger one stands at half the angle of (half, 2 G01).
  const double angle = radius > 0 ? std::abs(std::atan2(2 * g.xy, half)) / 2 : 0;
  const double column = angle / (std::numbers::pi / 8);
  const auto below = static_cast<std::size_t>(std::min(column, 3.0));
  const auto& rows = measured.rows;
  const Coefficients large =
      blended(rows[1 + below], rows[2 + below], column - static_cast<double>(below));
  Coefficients c = blended(rows[0], large, std::clamp(6 * (stretch - 1), 0.0, 1.0));
  for (double& value : c) value = 2 * std::max(value, 0.0);
  return c;
}

/// Linear forms of (G00, G11, 2 G01): stretch along five directions, shear, area, and differences.
std::array<std::array<double, 3>, Ridges::form_count> linear_forms() {
  std::array<std::array<double, 3>, Ridges::form_count> forms{};
  for (std::size_t k = 0; k < 5; ++k) {
    const double angle = static_cast<double>(k) * std::numbers::pi / 8;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    // The outer two are axes of symmetry, free of shear to the last bit.
    forms[k] = {c * c, s * s, k == 0 || k == 4 ? 0.0 : c * s};
  }
  forms[4] = {0, 1, 0};
  forms[5] = {0, 0, 1};
  forms[6] = {1, 1, 0};
  forms[7] = {1, 0.5, 0};
  forms[8] = {0.5, 1, 0};
  forms[9] = {1, -1, 0};
  forms[10] = {1, -0.5, 0};
  forms[11] = {0.5, -1, 0};
  return forms;
}

/// Integral from 0 to the strain of the hat of a knot: 1 there, 0 at its neighbours, linear
/// between; those at the ends stay at 1 beyond.
double hat_integral(int knot, double strain) {
  const auto upto = [&](double u) {
    if (knot == 0 && u < 0) return u + 0.5;
    if (knot == Ridges::breakpoint_count - 1 && u > 0) return u + 0.5;
    if (u <= -1) return 0.0;
    if (u >= 1) return 1.0;
    return u < 0 ? (1 + u) * (1 + u) / 2 : 1 - (1 - u) * (1 - u) / 2;
  };
  const double from = Ridges::zero_breakpoint - knot;
  return Ridges::step() * (upto(from + strain / Ridges::step()) - upto(from));
}

/// A strain of the fit and the stress that the tables give there.
struct Target {
  Strain strain;
  Strain stress;
  double weight;
};

std::vector<Target> targets(const std::vector<double>& samples) {
  const Samples law{samples.data()};
  std::vector<Target> all;
  for (int i = 0; i <= 14; ++i)
    for (int j = 0; j <= 20; ++j)
      for (int k = 0; k <= 8; ++k) {
        const double large = 1 + 0.025 * i;
        const double small = 0.85 + 0.025 * j;
        if (small > large + 1e-9) continue;
        const double angle = k * std::numbers::pi / 16;
        const double a = (large * large - 1) / 2;
        const double b = (small * small - 1) / 2;
        const double c = std::cos(angle);
        const double s = std::sin(angle);
        const Strain g{a * c * c + b * s * s, (a - b) * c * s, a * s * s + b * c * c};
        const double size = std::sqrt(g.xx * g.xx + 2 * g.xy * g.xy + g.yy * g.yy);
        if (size < 1e-6) continue;
        all.push_back({g, law.response(g, false).stress, 1 / size});
      }
  return all;
}

constexpr std::size_t unknown_count =
    static_cast<std::size_t>(Ridges::form_count) * Ridges::breakpoint_count;

/// Least squares with unknowns that are not negative: c^T A c / 2 - b^T c.
struct Quadratic {
  std::vector<double> a = std::vector<double>(unknown_count * unknown_count, 0);
  std::vector<double> b = std::vector<double>(unknown_count, 0);
};

/// The three stresses of each unknown at one strain, weighted; the shear counts twice, as in S:S.
void add_target(const Target& target, Quadratic& q) {
  static const auto forms = linear_forms();
  std::array<std::vector<double>, 3> rows;
  for (auto& row : rows) row.assign(unknown_count, 0);
  for (std::size_t f = 0; f < forms.size(); ++f)
    for (const double sign : {1.0, -1.0}) {
      if (sign < 0 && forms[f][2] == 0) continue;
      const double a[3] = {forms[f][0], forms[f][1], sign * forms[f][2]};
      const double strain =
          a[0] * target.strain.xx + a[1] * target.strain.yy + 2 * a[2] * target.strain.xy;
      for (int knot = 0; knot < Ridges::breakpoint_count; ++knot) {
        const double slope = hat_integral(knot, strain) * target.weight;
        const std::size_t u = f * Ridges::breakpoint_count + static_cast<std::size_t>(knot);
        for (std::size_t k = 0; k < 3; ++k) rows[k][u] += slope * a[k];
      }
    }
  const double stress[3] = {target.stress.xx, target.stress.yy, target.stress.xy};
  for (std::size_t k = 0; k < 3; ++k) {
    const double factor = k == 2 ? 2 : 1;
    std::vector<std::size_t> used;
    for (std::size_t u = 0; u < unknown_count; ++u)
      if (rows[k][u] != 0) used.push_back(u);
    for (const std::size_t u : used) {
      q.b[u] += factor * rows[k][u] * stress[k] * target.weight;
      for (const std::size_t v : used)
        q.a[u * unknown_count + v] += factor * rows[k][u] * rows[k][v];
    }
  }
}

/// What no strain tells apart is settled by smoothness: second differences along the knots, and
/// the size of all, count a little.
void regularise(Quadratic& q) {
  double trace = 0;
  for (std::size_t u = 0; u < unknown_count; ++u) trace += q.a[u * unknown_count + u];
  const double smooth = 1e-4 * trace / static_cast<double>(unknown_count);
  for (std::size_t u = 0; u < unknown_count; ++u) q.a[u * unknown_count + u] += 1e-3 * smooth;
  for (std::size_t u = 0; u + 2 < unknown_count; ++u) {
    if (u % Ridges::breakpoint_count + 2 >= Ridges::breakpoint_count) continue;
    constexpr double second[3] = {1, -2, 1};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        q.a[(u + i) * unknown_count + u + j] += smooth * second[i] * second[j];
  }
}

/// One unknown after the other to where it is best, given the others, and not negative. Each step
/// lowers the sum; the number of sweeps is fixed, so that the result is as well.
std::vector<double> solve_not_negative(const Quadratic& q) {
  std::vector<double> c(unknown_count, 0);
  std::vector<double> gradient(unknown_count);
  for (std::size_t u = 0; u < unknown_count; ++u) gradient[u] = -q.b[u];
  for (int sweep = 0; sweep < 1500; ++sweep)
    for (std::size_t u = 0; u < unknown_count; ++u) {
      const double* row = q.a.data() + u * unknown_count;
      const double next = std::max(0.0, c[u] - gradient[u] / row[u]);
      const double change = next - c[u];
      if (change == 0) continue;
      c[u] = next;
      for (std::size_t v = 0; v < unknown_count; ++v) gradient[v] += change * row[v];
    }
  return c;
}

/// Curvatures at the knots, integrated twice from the knot at 0.
std::vector<double> ridge_values(const std::vector<double>& curvatures) {
  const auto forms = linear_forms();
  std::vector<double> values(Ridges::value_count, 0);
  constexpr double step = Ridges::step();
  for (std::size_t f = 0; f < forms.size(); ++f) {
    double* form = values.data() + f * Ridges::form_size;
    double* w2 = form + 3;
    double* w1 = w2 + Ridges::breakpoint_count;
    double* w0 = w1 + Ridges::breakpoint_count;
    std::copy(forms[f].begin(), forms[f].end(), form);
    std::copy_n(curvatures.begin() + static_cast<std::ptrdiff_t>(f) * Ridges::breakpoint_count,
                Ridges::breakpoint_count, w2);
    for (int i = Ridges::zero_breakpoint; i + 1 < Ridges::breakpoint_count; ++i) {
      w1[i + 1] = w1[i] + step * (w2[i] + w2[i + 1]) / 2;
      w0[i + 1] = w0[i] + step * w1[i] + step * step * (2 * w2[i] + w2[i + 1]) / 6;
    }
    for (int i = Ridges::zero_breakpoint; i > 0; --i) {
      w1[i - 1] = w1[i] - step * (w2[i] + w2[i - 1]) / 2;
      w0[i - 1] = w0[i] - step * w1[i] + step * step * (2 * w2[i] + w2[i - 1]) / 6;
    }
  }
  return values;
}

}  // namespace

std::vector<double> sample_measured(const MeasuredStretch& measured) {
  std::vector<double> samples;
  samples.reserve(Samples::value_count);
  const auto at = [](int i) { return static_cast<double>(i) / Samples::side; };
  for (int i = 0; i < Samples::side; ++i)
    for (int j = 0; j < Samples::side; ++j)
      for (int k = 0; k < Samples::side; ++k) {
        const Coefficients c =
            evaluate(measured, {Samples::origin() + at(i), at(k), Samples::origin() + at(j)});
        samples.insert(samples.end(), c.begin(), c.end());
      }
  return samples;
}

MeasuredFit fit_measured(const MeasuredStretch& measured) {
  const std::vector<double> samples = sample_measured(measured);
  const std::vector<Target> all = targets(samples);
  Quadratic q;
  for (const Target& target : all) add_target(target, q);
  regularise(q);
  MeasuredFit fit;
  fit.values = ridge_values(solve_not_negative(q));
  const Ridges law{fit.values.data()};
  double error = 0;
  double total = 0;
  for (const Target& t : all) {
    const Strain s = law.response(t.strain, false).stress;
    const auto size_sq = [&](double xx, double yy, double xy) {
      return t.weight * t.weight * (xx * xx + yy * yy + 2 * xy * xy);
    };
    error += size_sq(s.xx - t.stress.xx, s.yy - t.stress.yy, s.xy - t.stress.xy);
    total += size_sq(t.stress.xx, t.stress.yy, t.stress.xy);
  }
  fit.error = total > 0 ? std::sqrt(error / total) : 0;
  return fit;
}

std::vector<double> stretch_table(const Material& material) {
  if (!material.measured) return {};
  return material.measured->form == MeasuredStretch::Form::arcsim
             ? sample_measured(*material.measured)
             : fit_measured(*material.measured).values;
}

}  // namespace weft
