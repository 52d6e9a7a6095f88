#pragma once

#include <cmath>

#include "weft/elements/membrane_law.hpp"
#include "weft/elements/scalar.hpp"

// Stiffening near given principal stretches, to be added to any law of stretching:
//   W = phi(g1) + phi(g2),  g1 >= g2 the eigenvalues of the Green strain G, (stretch^2 - 1) / 2
// phi is zero up to half of the strain at a limit. With y the place between there (0) and the limit
// (1), and w the strain between the two,
//   phi'' = k y^2,  phi' = k w y^3 / 3 and phi = k w^2 y^4 / 12 as far as y <= 1
// and phi'' = k beyond, so that it is convex, twice differentiable and finite for any strain. At
// the limit it holds a stress of k w / 3 and has taken up an energy per area of k w^2 / 12. As phi
// begins early, the tangent of a step's start already tells of it. As phi is convex so is W as a
// function of G (Davis 1957): its tangent is positive semi-definite.

// Inlined into a kernel this would cost materials without limits half of the threads that a GPU
// can hold: 116 registers a thread instead of 64 in single precision.
#if defined(__CUDACC__)
#define WEFT_OUT_OF_LINE __noinline__
#else
#define WEFT_OUT_OF_LINE
#endif

namespace weft {

/// What phi adds on one side.
template <class T>
struct LimitBand {
  T width = 0;      ///< [1] w, of the strain's sign: phi begins at w, and the limit is 2 w
  T width_inv = 0;  ///< [1] 1 / w; 0: no limit
  T stiffness = 0;  ///< [N/m] k, phi'' at the limit and beyond

  /// phi and its derivatives at a strain.
  struct Value {
    T energy, slope, curvature;  ///< [N/m]
  };
  WEFT_HD constexpr Value at(T strain) const noexcept {
    const T y = greater(strain * width_inv - T(1), T(0));
    const T near = lesser(y, T(1));
    const T beyond = y - near;
    const T curvature = stiffness * near * near;
    return {curvature * width * width *
                (near * near / T(12) + near * beyond / T(3) + beyond * beyond / T(2)),
            curvature * width * (near / T(3) + beyond), curvature};
  }
};

/// Both limits. A law in the sense of membrane_law.hpp.
/// @cite davis1957, convexity of functions of eigenvalues
template <class T>
struct MembraneLimits {
  LimitBand<T> low, high;
  /// [1] eigenvalues closer than twice this are taken for one where only their difference counts
  T near = 0;

  T force = T(0);  ///< [N] that a triangle holds at its limits, whatever its size

  WEFT_HD constexpr bool any() const noexcept {
    return low.stiffness > T(0) || high.stiffness > T(0);
  }

  /// Those of a triangle. A force on a vertex is the greater a stress the smaller its triangles
  /// are.
  /// @param area [m^2] at rest
  WEFT_HD MembraneLimits of_triangle(T area) const noexcept {
    using std::fabs;
    using std::sqrt;
    MembraneLimits limits = *this;
    const T least = force > T(0) ? T(3) * force / sqrt(area) : T(0);
    limits.low.stiffness = greater(low.stiffness, least * fabs(low.width_inv));
    limits.high.stiffness = greater(high.stiffness, least * fabs(high.width_inv));
    return limits;
  }

  WEFT_HD T energy(const detail::Symmetric2<T>& g) const noexcept {
    const Spectrum s(g);
    return at(s.mean + s.radius).energy + at(s.mean - s.radius).energy;
  }

  WEFT_HD MembraneResponse<T> response(const detail::Symmetric2<T>& g,
                                       bool /*project*/) const noexcept {
    MembraneResponse<T> r{};
    add(g, r);
    return r;
  }

  /// By how much the energy at another strain differs from its expansion to second order about a
  /// strain, without regard to the sign, one principal strain after the other. [N/m]
  WEFT_HD T expansion_error(const detail::Symmetric2<T>& about,
                            const detail::Symmetric2<T>& other) const noexcept {
    const Spectrum from(about);
    const Spectrum to(other);
    return expansion_error(from.mean + from.radius, to.mean + to.radius) +
           expansion_error(from.mean - from.radius, to.mean - to.radius);
  }

  /// Whether a strain is within the limits.
  WEFT_HD bool holds(const detail::Symmetric2<T>& g) const noexcept {
    const Spectrum s(g);
    return holds(s.mean + s.radius) && holds(s.mean - s.radius);
  }

  /// By how much principal stretches exceed their limits, over what the limit allows, |limit - 1|:
  /// the larger of both; 0 within. [1]
  WEFT_HD T excess(const detail::Symmetric2<T>& g) const noexcept {
    const Spectrum s(g);
    return greater(excess(s.mean + s.radius), excess(s.mean - s.radius));
  }

  /// Adds stress and tangent to those of another law.
  WEFT_OUT_OF_LINE WEFT_HD void add(const detail::Symmetric2<T>& g,
                                    MembraneResponse<T>& r) const noexcept {
    const Spectrum s(g);
    const typename LimitBand<T>::Value a = at(s.mean + s.radius);
    const typename LimitBand<T>::Value b = at(s.mean - s.radius);
    if (a.curvature + b.curvature == T(0)) return;  // well within both
    // (phi'(g1) - phi'(g2)) / (g1 - g2), or the mean of phi'' where that would cancel.
    const T mixed = s.radius > near ? (a.slope - b.slope) / (T(2) * s.radius)
                                    : (a.curvature + b.curvature) / T(2);
    const T mean = (a.slope + b.slope) / T(2);
    r.stress.xx += mean + mixed * s.half;
    r.stress.xy += mixed * g.xy;
    r.stress.yy += mean - mixed * s.half;
    // In the eigenvectors' frame the tangent is diagonal: phi''(g1), phi''(g2), and `mixed` for the
    // shear. (c, s) is twice the angle of the first.
    const T c = s.radius > T(0) ? s.half / s.radius : T(1);
    const T n = s.radius > T(0) ? g.xy / s.radius : T(0);
    const T sum = (a.curvature + b.curvature) / T(4);
    const T difference = (a.curvature - b.curvature) / T(4);
    const T shear = (mixed > T(0) ? mixed : T(0)) / T(2);
    const T cc = sum * c * c + shear * n * n;
    const T cn = (sum - shear) * c * n;
    r.tangent[0] += sum + cc + T(2) * difference * c;
    r.tangent[1] += sum - cc;
    r.tangent[2] += cn + difference * n;
    r.tangent[3] += sum + cc - T(2) * difference * c;
    r.tangent[4] += difference * n - cn;
    r.tangent[5] += sum * n * n + shear * c * c;
  }

 private:
  /// Eigenvalues mean +- radius of a symmetric matrix.
  struct Spectrum {
    T mean, half, radius;
    WEFT_HD explicit Spectrum(const detail::Symmetric2<T>& g) noexcept
        : mean((g.xx + g.yy) / T(2)), half((g.xx - g.yy) / T(2)), radius(0) {
      using std::sqrt;
      radius = sqrt(half * half + g.xy * g.xy);
    }
  };
  WEFT_HD constexpr typename LimitBand<T>::Value at(T strain) const noexcept {
    return (strain > T(0) ? high : low).at(strain);
  }
  WEFT_HD constexpr bool holds(T strain) const noexcept {
    return strain * (strain > T(0) ? high : low).width_inv <= T(2);
  }
  WEFT_HD T excess(T strain) const noexcept {
    using std::sqrt;
    if (holds(strain)) return T(0);
    const T limit = sqrt(T(1) + T(4) * (strain > T(0) ? high : low).width);
    const T stretch = sqrt(greater(T(1) + T(2) * strain, T(0)));
    return (stretch - limit) / (limit - T(1));
  }
  WEFT_HD T expansion_error(T about, T other) const noexcept {
    using std::fabs;
    const typename LimitBand<T>::Value a = at(about);
    const T d = other - about;
    return fabs(at(other).energy - a.energy - d * (a.slope + d * a.curvature / T(2)));
  }
};

/// @param min, max  [1]   principal stretches, 0 <= min < 1 < max; min 0, max infinite: no limit
/// @param stiffness [N/m] at the limits, > 0
/// @param energy    [N/m] energy per area that the limits take up at least
template <class T>
WEFT_HD constexpr MembraneLimits<T> membrane_limits(T min, T max, T stiffness,
                                                    T energy = T(0)) noexcept {
  MembraneLimits<T> limits;
  const auto band = [&](T stretch) {
    const T half = (stretch * stretch - T(1)) / T(4);
    return LimitBand<T>{half, T(1) / half, greater(stiffness, T(12) * energy / (half * half))};
  };
  T least = T(1);
  if (min > T(0)) {
    limits.low = band(min);
    least = -limits.low.width;
  }
  if (max * max < T(1e30)) {
    limits.high = band(max);
    least = lesser(least, limits.high.width);
  }
  limits.near = least * T(0.002);
  return limits;
}

}  // namespace weft

#undef WEFT_OUT_OF_LINE
