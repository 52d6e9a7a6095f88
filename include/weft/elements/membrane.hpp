#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

// Isotropic St. Venant-Kirchhoff sheet on a linear triangle, in plane stress.
//   F = [x1 - x0, x2 - x0] inv_rest,  G = (F^T F - I) / 2,  S = 2 mu G + lambda tr(G) I
//   energy = area (mu G:G + lambda / 2 tr(G)^2),  dE/dF = area F S
// The thickness is part of the constants, so area stands for volume. Energies are finite for any
// finite x; an inverted (mirrored) triangle has the energy of its mirror image.

namespace weft {

/// Constants of the sheet, thickness included [N/m].
template <class T>
struct MembraneConstants {
  T lambda;
  T mu;
};

/// Plane-stress constants of an isotropic sheet.
///   lambda = stiffness nu / (1 - nu^2),  mu = stiffness / (2 (1 + nu))
/// @param stiffness [N/m] Young's modulus times thickness, >= 0
/// @param nu        [1]   Poisson's ratio, -1 < nu < 1
/// @cite bonet2008, plane stress of the St. Venant-Kirchhoff material
template <class T>
WEFT_HD constexpr MembraneConstants<T> membrane_constants(T stiffness, T nu) noexcept {
  return {stiffness * nu / (T(1) - nu * nu), stiffness / (T(2) * (T(1) + nu))};
}

namespace detail {

/// Symmetric 2x2 matrix [xx, xy; xy, yy].
template <class T>
struct Symmetric2 {
  T xx, xy, yy;
};

/// The nearest positive semi-definite matrix: negative eigenvalues become zero.
template <class T>
WEFT_HD Symmetric2<T> project_semidefinite(const Symmetric2<T>& s) noexcept {
  using std::sqrt;
  const T mean = (s.xx + s.yy) / T(2);
  const T half = (s.xx - s.yy) / T(2);
  const T radius = sqrt(half * half + s.xy * s.xy);
  if (mean >= radius) return s;
  if (mean <= -radius) return {T(0), T(0), T(0)};
  // The eigenvalues are mean +- radius: scale the projector onto the positive one.
  const T scale = (mean + radius) / (T(2) * radius);
  return {scale * (half + radius), scale * s.xy, scale * (radius - half)};
}

/// Columns of F [1] and the Green strain G [1].
template <class T>
struct MembraneStrain {
  Vec3<T> f0, f1;
  Symmetric2<T> green;
};

template <class T>
WEFT_HD MembraneStrain<T> membrane_strain(const Vec3<T> x[3], const Mat2<T>& inv_rest) noexcept {
  const Vec3<T> d1 = x[1] - x[0];
  const Vec3<T> d2 = x[2] - x[0];
  const Vec3<T> f0 = d1 * inv_rest(0, 0) + d2 * inv_rest(1, 0);
  const Vec3<T> f1 = d1 * inv_rest(0, 1) + d2 * inv_rest(1, 1);
  const T half = T(0.5);
  return {
      f0, f1, {half * (length_sq(f0) - T(1)), half * dot(f0, f1), half * (length_sq(f1) - T(1))}};
}

/// Second Piola-Kirchhoff stress S [N/m].
template <class T>
WEFT_HD Symmetric2<T> membrane_stress(const Symmetric2<T>& green,
                                      const MembraneConstants<T>& c) noexcept {
  const T two_mu = T(2) * c.mu;
  const T pressure = c.lambda * (green.xx + green.yy);
  return {two_mu * green.xx + pressure, two_mu * green.xy, two_mu * green.yy + pressure};
}

template <class T>
WEFT_HD void membrane_forces(const MembraneStrain<T>& m, const Symmetric2<T>& s,
                             const Mat2<T>& inv_rest, T area, Vec3<T> g[3]) noexcept {
  const Vec3<T> p0 = (m.f0 * s.xx + m.f1 * s.xy) * area;
  const Vec3<T> p1 = (m.f0 * s.xy + m.f1 * s.yy) * area;
  g[1] = p0 * inv_rest(0, 0) + p1 * inv_rest(0, 1);
  g[2] = p0 * inv_rest(1, 0) + p1 * inv_rest(1, 1);
  g[0] = -(g[1] + g[2]);
}

/// Blocks for all corners from those of the corners 1 and 2, as each row of blocks sums to zero.
template <class T>
WEFT_HD void complete_membrane_blocks(Mat3<T> h[6]) noexcept {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      h[1](i, j) = -(h[3](i, j) + h[4](j, i));
      h[2](i, j) = -(h[4](i, j) + h[5](i, j));
      h[0](i, j) = (h[3](i, j) + h[5](i, j)) + (h[4](i, j) + h[4](j, i));
    }
}

/// With the rows b1, b2 of inv_rest and u_i = F b_i, block (i, j) is area times
///   (b_i . S b_j) I + mu (b_i . b_j) F F^T + mu u_j u_i^T + lambda u_i u_j^T
template <class T>
WEFT_HD void membrane_blocks(const MembraneStrain<T>& m, const Symmetric2<T>& s,
                             const Mat2<T>& inv_rest, T area, const MembraneConstants<T>& c,
                             Mat3<T> h[6]) noexcept {
  const T b1x = inv_rest(0, 0), b1y = inv_rest(0, 1);
  const T b2x = inv_rest(1, 0), b2y = inv_rest(1, 1);
  const T mu = area * c.mu;
  const T lambda = area * c.lambda;
  const T mu11 = mu * (b1x * b1x + b1y * b1y);
  const T mu12 = mu * (b1x * b2x + b1y * b2y);
  const T mu22 = mu * (b2x * b2x + b2y * b2y);
  const T s1x = area * (s.xx * b1x + s.xy * b1y), s1y = area * (s.xy * b1x + s.yy * b1y);
  const T s2x = area * (s.xx * b2x + s.xy * b2y), s2y = area * (s.xy * b2x + s.yy * b2y);
  const Vec3<T> u1 = m.f0 * b1x + m.f1 * b1y;
  const Vec3<T> u2 = m.f0 * b2x + m.f1 * b2y;
  const T both = mu + lambda;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const T left = m.f0[i] * m.f0[j] + m.f1[i] * m.f1[j];
      h[3](i, j) = mu11 * left + both * (u1[i] * u1[j]);
      h[4](i, j) = mu12 * left + (mu * u2[i] * u1[j] + lambda * u1[i] * u2[j]);
      h[5](i, j) = mu22 * left + both * (u2[i] * u2[j]);
    }
  for (int i = 0; i < 3; ++i) {
    h[3](i, i) += s1x * b1x + s1y * b1y;
    h[4](i, i) += s1x * b2x + s1y * b2y;
    h[5](i, i) += s2x * b2x + s2y * b2y;
  }
  complete_membrane_blocks(h);
}

}  // namespace detail

/// Membrane energy of one triangle [J].
/// @param x        [m]   [3] x Vec3, deformed corners
/// @param inv_rest [1/m] 2x2, inverse of [X1 - X0, X2 - X0] in material coordinates
/// @param area     [m^2] rest area
/// @param c        [N/m] constants of the sheet
/// @pre   area > 0; checked at load
/// @cite volino2009, with the linear isotropic law of bonet2008
template <class T>
WEFT_HD T membrane_energy(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                          const MembraneConstants<T>& c) noexcept {
  const detail::Symmetric2<T> g = detail::membrane_strain(x, inv_rest).green;
  const T trace = g.xx + g.yy;
  return area * (c.mu * (g.xx * g.xx + T(2) * g.xy * g.xy + g.yy * g.yy) +
                 T(0.5) * c.lambda * trace * trace);
}

/// Gradient of membrane_energy; the parameters are the same.
/// @param g [N] out, [3] x Vec3, dE/dx; the force is its negative; sums to zero
template <class T>
WEFT_HD void membrane_gradient(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                               const MembraneConstants<T>& c, Vec3<T> g[3]) noexcept {
  const auto m = detail::membrane_strain(x, inv_rest);
  detail::membrane_forces(m, detail::membrane_stress(m.green, c), inv_rest, area, g);
}

/// Hessian of membrane_energy; the parameters are the same.
/// @param project  false: exact; true: the stress S of the geometric part loses its negative
///                 eigenvalues, which makes the whole positive semi-definite (the material part
///                 always is) and changes nothing where no direction is compressed
/// @param h        [N/m] out, blocks (0,0), (0,1), (0,2), (1,1), (1,2), (2,2); (j,i) = (i,j)^T
/// @cite teran2005, for the projection in closed form
template <class T>
WEFT_HD void membrane_hessian(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                              const MembraneConstants<T>& c, bool project, Mat3<T> h[6]) noexcept {
  const auto m = detail::membrane_strain(x, inv_rest);
  const detail::Symmetric2<T> s = detail::membrane_stress(m.green, c);
  detail::membrane_blocks(m, project ? detail::project_semidefinite(s) : s, inv_rest, area, c, h);
}

/// membrane_gradient and the projected membrane_hessian at once, to the same bits.
/// @param g [N]   out, as membrane_gradient
/// @param h [N/m] out, as membrane_hessian with project = true
template <class T>
WEFT_HD void membrane_gradient_hessian(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                                       const MembraneConstants<T>& c, Vec3<T> g[3],
                                       Mat3<T> h[6]) noexcept {
  const auto m = detail::membrane_strain(x, inv_rest);
  const detail::Symmetric2<T> s = detail::membrane_stress(m.green, c);
  detail::membrane_forces(m, s, inv_rest, area, g);
  detail::membrane_blocks(m, detail::project_semidefinite(s), inv_rest, area, c, h);
}

}  // namespace weft
