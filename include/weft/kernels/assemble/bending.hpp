#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/hinge.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// Bending and its damping, hinge by hinge, scaled as in AssembleMembrane. The Jacobian is kept in
/// factored form: block (i, j) of hinge n is curvature[n] * outer(direction[4n + i], direction[4n +
/// j]). Reads: positions and velocities of all corners. Writes: direction, impulse_scale, curvature
/// of its own hinge. Order: independent. Ghosts: all vertices. Flags: none.
template <class T>
struct AssembleBending {
  Span<const Hinge> hinges;        ///< [n] global vertex numbers
  Span<const T> stiffness;         ///< [n] [N m] c in W = c (theta - rest)^2
  Span<const T> rest_angle;        ///< [n] [rad]
  Span<const T> damping;           ///< [n] [s] Rayleigh b
  Span<const Vec3<T>> positions;   ///< [m] iterate x_k
  Span<const Vec3<T>> velocities;  ///< [m/s] iterate v_k; empty: zero
  T h;                             ///< [s] effective time step
  Span<Vec3<T>> direction;         ///< [4n] [1/m] gradient of theta by each corner
  Span<T> impulse_scale;           ///< [n] [N m s] h f of corner i is this times direction i
  Span<T> curvature;               ///< [n] [kg m^2]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(hinges.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto n = static_cast<std::size_t>(i);
    const Hinge& hinge = hinges[n];
    Vec3<T> x[4];
    for (int c = 0; c < 4; ++c) x[c] = positions[static_cast<std::size_t>(hinge.v[c])];
    Vec3<T>* g = direction.data() + 4 * n;
    const T theta = hinge_angle_gradient(x, g);
    const T k = T(2) * stiffness[n];
    T torque = -k * (theta - rest_angle[n]);
    if (!velocities.empty() && damping[n] > T(0)) {
      T rate = T(0);
      for (int c = 0; c < 4; ++c)
        rate += dot(g[c], velocities[static_cast<std::size_t>(hinge.v[c])]);
      torque -= damping[n] * k * rate;
    }
    impulse_scale[n] = h * torque;
    curvature[n] = h * (h + damping[n]) * k;
  }
};

}  // namespace weft
