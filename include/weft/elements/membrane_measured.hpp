#pragma once

#include "weft/elements/membrane_law.hpp"

// Laws of stretching after measured tables (Wang, O'Brien and Ramamoorthi 2011), in two forms: the
// tables as ARCSim evaluates them, which is a stress without an energy, and an energy fitted to
// them. Both are views of numbers that host/scene/fabric/measured.hpp makes.

namespace weft {

/// Samples of the coefficients over strain, interpolated in G00, G11 and |G01|, clamped outside.
/// The stress is that of OrthotropicMembrane with the coefficients of the strain at hand. It is no
/// derivative of an energy; the tangent is that of frozen coefficients.
template <class T>
struct MembraneSamples {
  static constexpr int side = 30;  ///< samples along each axis
  static constexpr int value_count = side * side * side * 4;

  const T* values;  ///< [side][side][side][4] over G00, G11, |G01|: c11, c12, c22, c33 [N/m]

  /// First sample of G00 and of G11; that of |G01| is 0. Samples are 1/30 apart.
  WEFT_HD static constexpr T origin() noexcept { return T(-0.25); }

  /// Coefficients at a strain.
  WEFT_HD OrthotropicMembrane<T> coefficients(const detail::Symmetric2<T>& g) const noexcept {
    const T shear = g.xy < T(0) ? -g.xy : g.xy;
    const T at[3] = {place(g.xx - origin()), place(g.yy - origin()), place(shear)};
    int cell[3];
    T share[3];
    for (int k = 0; k < 3; ++k) {
      cell[k] = at[k] < T(side - 2) ? static_cast<int>(at[k]) : side - 2;
      share[k] = at[k] - T(cell[k]);
    }
    T c[4] = {T(0), T(0), T(0), T(0)};
    for (int corner = 0; corner < 8; ++corner) {
      T weight = T(1);
      int index = 0;
      for (int k = 0; k < 3; ++k) {
        const int up = (corner >> (2 - k)) & 1;
        weight *= up != 0 ? share[k] : T(1) - share[k];
        index = index * side + cell[k] + up;
      }
      for (int j = 0; j < 4; ++j) c[j] += weight * values[4 * index + j];
    }
    return {c[0], c[1], c[2], c[3]};
  }

  /// @param project the tangent loses its negative eigenvalues; the stress is the same
  WEFT_HD MembraneResponse<T> response(const detail::Symmetric2<T>& g,
                                       bool project) const noexcept {
    const OrthotropicMembrane<T> c = coefficients(g);
    MembraneResponse<T> r = c.response(g, false);
    if (!project) return r;
    // The shear stands alone, and no sample is negative.
    const auto threads = detail::project_semidefinite(detail::Symmetric2<T>{c.c11, c.c12, c.c22});
    r.tangent[0] = threads.xx;
    r.tangent[1] = threads.xy;
    r.tangent[3] = threads.yy;
    return r;
  }

  /// S:G / 2 [J/m^2], for reports: what the coefficients at hand would store. Not a potential.
  WEFT_HD T energy(const detail::Symmetric2<T>& g) const noexcept {
    return coefficients(g).energy(g);
  }

 private:
  /// A distance from the first sample, in samples, clamped; not a number becomes 0.
  WEFT_HD static T place(T distance) noexcept {
    const T p = distance * T(side);
    return p > T(0) ? (p < T(side - 1) ? p : T(side - 1)) : T(0);
  }
};

/// Sum of convex functions of linear forms of the strain,
///   W = sum over k of w_k(a_k0 G00 + a_k1 G11 + a_k2 2 G01) + w_k(.. with -a_k2)
/// where the second term stands only if a_k2 is not zero, so that both threads are axes of
/// symmetry. w_k'' is piecewise linear over knots, constant beyond, and never negative; w_k and
/// w_k' vanish at 0. So W is convex in G, twice differentiable, and the tangent is exact and
/// positive semi-definite.
template <class T>
struct MembraneRidges {
  static constexpr int form_count = 12;
  static constexpr int breakpoint_count = 25;
  static constexpr int zero_breakpoint = 8;  ///< the knot at strain 0
  static constexpr int form_size = 3 + 3 * breakpoint_count;
  static constexpr int value_count = form_count * form_size;

  /// [forms][form_size]: a_k, then w'', w' and w at each knot
  const T* values;

  /// Between knots.
  WEFT_HD static constexpr T step() noexcept { return T(0.05); }

  /// w, w' and w'' of a form at a strain.
  struct Ridge {
    T value, slope, curvature;
  };
  WEFT_HD static Ridge ridge(const T* form, T strain) noexcept {
    const T* curvature = form + 3;
    const T* slope = curvature + breakpoint_count;
    const T* value = slope + breakpoint_count;
    T place = strain / step() + T(zero_breakpoint);
    place =
        place > T(0) ? (place < T(breakpoint_count - 1) ? place : T(breakpoint_count - 1)) : T(0);
    const int i = place < T(breakpoint_count - 2) ? static_cast<int>(place) : breakpoint_count - 2;
    const bool beyond = !(place > T(0)) || !(place < T(breakpoint_count - 1));
    const int from = beyond && place > T(0) ? breakpoint_count - 1 : i;
    const T s = strain - T(from - zero_breakpoint) * step();
    const T c = curvature[from];
    const T third = beyond ? T(0) : (curvature[i + 1] - c) / step();
    return {value[from] + s * (slope[from] + s * (T(0.5) * c + s * third / T(6))),
            slope[from] + s * (c + T(0.5) * s * third), c + s * third};
  }

  WEFT_HD T energy(const detail::Symmetric2<T>& g) const noexcept {
    T sum = T(0);
    for (int k = 0; k < form_count; ++k) {
      const T* a = values + k * form_size;
      const T straight = a[0] * g.xx + a[1] * g.yy, turned = T(2) * a[2] * g.xy;
      sum += ridge(a, straight + turned).value;
      if (a[2] != T(0)) sum += ridge(a, straight - turned).value;
    }
    return sum;
  }

  WEFT_HD MembraneResponse<T> response(const detail::Symmetric2<T>& g,
                                       bool /*project*/) const noexcept {
    MembraneResponse<T> r{};
    for (int k = 0; k < form_count; ++k) {
      const T* a = values + k * form_size;
      const T straight = a[0] * g.xx + a[1] * g.yy, turned = T(2) * a[2] * g.xy;
      add(r, ridge(a, straight + turned), a[0], a[1], a[2]);
      if (a[2] != T(0)) add(r, ridge(a, straight - turned), a[0], a[1], -a[2]);
    }
    return r;
  }

 private:
  WEFT_HD static void add(MembraneResponse<T>& r, const Ridge& w, T a0, T a1, T a2) noexcept {
    r.stress.xx += w.slope * a0;
    r.stress.yy += w.slope * a1;
    r.stress.xy += w.slope * a2;
    const T t0 = w.curvature * a0, t1 = w.curvature * a1;
    r.tangent[0] += t0 * a0;
    r.tangent[1] += t0 * a1;
    r.tangent[2] += t0 * a2;
    r.tangent[3] += t1 * a1;
    r.tangent[4] += t1 * a2;
    r.tangent[5] += w.curvature * a2 * a2;
  }
};

}  // namespace weft
