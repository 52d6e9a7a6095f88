#pragma once

#include <cmath>

#include "weft/elements/membrane_law.hpp"
#include "weft/elements/scalar.hpp"

// Stiffening near given principal stretches, to be added to any law of stretching:
//   W = phi(g1) + phi(g2),  g1 >= g2 the eigenvalues of the Green strain G, (stretch^2 - 1) / 2
// phi is zero up to half of the strain at a limit. With y the place between there (0) and the limit
// (1), and w the strain between the two,
//   phi'' = k min(y, 4)^2,  phi' = k w y^3 / 3 and phi = k w^2 y^4 / 12 as far as y <= 4
// so that it is convex, twice differentiable, finite for any strain, and stiff enough at the limit
// to hold loads that the law itself would yield to, while the tangent of a step's start already
// tells of it. As phi is convex so is W as a function of G (Davis 1957): its tangent is positive
// semi-definite.

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
  T stiffness = 0;  ///< [N/m] k, phi'' at the limit

  /// phi and its derivatives at a strain.
  struct Value {
    T energy, slope, curvature;  ///< [N/m]
  };
  WEFT_HD constexpr Value at(T strain) const noexcept {
    const T y = greater(strain * width_inv - T(1), T(0));
    const T near = lesser(y, T(4));
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

  WEFT_HD constexpr bool any() const noexcept {
    return low.stiffness > T(0) || high.stiffness > T(0);
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
  WEFT_HD T expansion_error(T about, T other) const noexcept {
    using std::fabs;
    const typename LimitBand<T>::Value a = at(about);
    const T d = other - about;
    return fabs(at(other).energy - a.energy - d * (a.slope + d * a.curvature / T(2)));
  }
};

/// @param min, max  [1]   principal stretches, 0 <= min < 1 < max; min 0, max infinite: no limit
/// @param stiffness [N/m] at the limits, > 0
template <class T>
WEFT_HD constexpr MembraneLimits<T> membrane_limits(T min, T max, T stiffness) noexcept {
  MembraneLimits<T> limits;
  const auto band = [&](T stretch) {
    const T half = (stretch * stretch - T(1)) / T(4);
    return LimitBand<T>{half, T(1) / half, stiffness};
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
