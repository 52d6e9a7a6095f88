#pragma once

#include "weft/elements/membrane.hpp"

// Sheets on a linear triangle whose stress is any function of the Green strain, and the simplest of
// them, the linear orthotropic one. A law is a type with
//   T energy(const detail::Symmetric2<T>& green) const                      [J/m^2]
//   MembraneResponse<T> response(const detail::Symmetric2<T>& green, bool project) const
// where `project` asks for a positive semi-definite tangent.
// The thickness is part of the constants, so area stands for volume; F, G, S as in membrane.hpp.

namespace weft {

/// Second Piola-Kirchhoff stress of a sheet, and how it changes with the strain.
template <class T>
struct MembraneResponse {
  detail::Symmetric2<T> stress;  ///< [N/m]
  /// [N/m] d(S00, S11, S01) / d(G00, G11, 2 G01): symmetric, the upper half row by row.
  T tangent[6];
};

/// Linear law in material axes, 0 the warp and 1 the weft:
///   S00 = c11 G00 + c12 G11,  S11 = c12 G00 + c22 G11,  S01 = c33 G01
/// Isotropic: c11 = c22 = 2 mu + lambda, c12 = lambda, c33 = 2 mu.
/// @pre c11, c22, c33 >= 0 and c12^2 <= c11 c22, so that the tangent is positive semi-definite
/// @cite wang2011
template <class T>
struct OrthotropicMembrane {
  T c11, c12, c22, c33;  ///< [N/m]

  WEFT_HD constexpr T energy(const detail::Symmetric2<T>& g) const noexcept {
    return T(0.5) * (c11 * g.xx * g.xx + c22 * g.yy * g.yy) + c12 * g.xx * g.yy + c33 * g.xy * g.xy;
  }
  WEFT_HD constexpr MembraneResponse<T> response(const detail::Symmetric2<T>& g,
                                                 bool /*project*/) const noexcept {
    return {{c11 * g.xx + c12 * g.yy, c33 * g.xy, c12 * g.xx + c22 * g.yy},
            {c11, c12, T(0), c22, T(0), T(0.5) * c33}};
  }
};

/// Plane-stress constants of an orthotropic sheet. With nu' = nu weft / warp:
///   c11 = warp / (1 - nu nu'),  c22 = weft / (1 - nu nu'),  c12 = nu c22,  c33 = 2 shear
/// @param warp, weft [N/m] Young's moduli times thickness, > 0
/// @param nu         narrowing along the weft over stretch along the warp, nu^2 < warp / weft
/// @param shear      [N/m] shear modulus times thickness, > 0
/// @cite bonet2008, inverse of the orthotropic compliance
template <class T>
WEFT_HD constexpr OrthotropicMembrane<T> orthotropic_membrane(T warp, T weft, T nu,
                                                              T shear) noexcept {
  const T scale = T(1) / (T(1) - nu * nu * weft / warp);
  return {scale * warp, scale * nu * weft, scale * weft, T(2) * shear};
}

namespace detail {

/// Rows of dG / dx of one corner with the row b of inv_rest: G00, G11, 2 G01.
template <class T>
struct StrainRows {
  Vec3<T> row[3];

  WEFT_HD StrainRows(const MembraneStrain<T>& m, T bx, T by) noexcept
      : row{m.f0 * bx, m.f1 * by, m.f0 * by + m.f1 * bx} {}
  /// The tangent times the rows.
  WEFT_HD void stressed(const T d[6], T area, Vec3<T> out[3]) const noexcept {
    out[0] = (row[0] * d[0] + row[1] * d[1] + row[2] * d[2]) * area;
    out[1] = (row[0] * d[1] + row[1] * d[3] + row[2] * d[4]) * area;
    out[2] = (row[0] * d[2] + row[1] * d[4] + row[2] * d[5]) * area;
  }
};

/// Block (i, j) is area times (b_i . S b_j) I + B_i^T D B_j, D the tangent and B_i = dG / dx_i.
template <class T>
WEFT_HD void membrane_law_blocks(const MembraneStrain<T>& m, const Symmetric2<T>& s,
                                 const T tangent[6], const Mat2<T>& inv_rest, T area,
                                 Mat3<T> h[6]) noexcept {
  const T b1x = inv_rest(0, 0), b1y = inv_rest(0, 1);
  const T b2x = inv_rest(1, 0), b2y = inv_rest(1, 1);
  const StrainRows<T> first(m, b1x, b1y), second(m, b2x, b2y);
  Vec3<T> t1[3], t2[3];
  first.stressed(tangent, area, t1);
  second.stressed(tangent, area, t2);
  const auto product = [](const StrainRows<T>& b, const Vec3<T> t[3], int i, int j) {
    return b.row[0][i] * t[0][j] + b.row[1][i] * t[1][j] + b.row[2][i] * t[2][j];
  };
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      h[4](i, j) = product(first, t2, i, j);
      if (j < i) continue;  // both are symmetric, to the last bit
      h[3](i, j) = h[3](j, i) = product(first, t1, i, j);
      h[5](i, j) = h[5](j, i) = product(second, t2, i, j);
    }
  const T s1x = area * (s.xx * b1x + s.xy * b1y), s1y = area * (s.xy * b1x + s.yy * b1y);
  const T s2x = area * (s.xx * b2x + s.xy * b2y), s2y = area * (s.xy * b2x + s.yy * b2y);
  for (int i = 0; i < 3; ++i) {
    h[3](i, i) += s1x * b1x + s1y * b1y;
    h[4](i, i) += s1x * b2x + s1y * b2y;
    h[5](i, i) += s2x * b2x + s2y * b2y;
  }
  complete_membrane_blocks(h);
}

}  // namespace detail

/// Membrane energy of one triangle [J] under a law.
/// @param x        [m]   [3] x Vec3, deformed corners
/// @param inv_rest [1/m] 2x2, inverse of [X1 - X0, X2 - X0] in material coordinates
/// @param area     [m^2] rest area
/// @pre   area > 0; checked at load
template <class T, class Law>
WEFT_HD T membrane_law_energy(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                              const Law& law) noexcept {
  return area * law.energy(detail::membrane_strain(x, inv_rest).green);
}

/// Gradient of membrane_law_energy; the parameters are the same.
/// @param g [N] out, [3] x Vec3, dE/dx; the force is its negative; sums to zero
template <class T, class Law>
WEFT_HD void membrane_law_gradient(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                                   const Law& law, Vec3<T> g[3]) noexcept {
  const auto m = detail::membrane_strain(x, inv_rest);
  detail::membrane_forces(m, law.response(m.green, false).stress, inv_rest, area, g);
}

/// Hessian of membrane_law_energy; the parameters are the same.
/// @param project  false: exact; true: the stress S of the geometric part and the tangent of the
///                 law lose their negative eigenvalues: the whole is positive semi-definite
/// @param h        [N/m] out, blocks (0,0), (0,1), (0,2), (1,1), (1,2), (2,2); (j,i) = (i,j)^T
template <class T, class Law>
WEFT_HD void membrane_law_hessian(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                                  const Law& law, bool project, Mat3<T> h[6]) noexcept {
  const auto m = detail::membrane_strain(x, inv_rest);
  const MembraneResponse<T> r = law.response(m.green, project);
  detail::membrane_law_blocks(m, project ? detail::project_semidefinite(r.stress) : r.stress,
                              r.tangent, inv_rest, area, h);
}

/// membrane_law_gradient and the projected membrane_law_hessian at once, to the same bits.
/// @param respond takes a Green strain and gives a law's response, projected
/// @param g [N]   out
/// @param h [N/m] out, [6]
template <class T, class Respond>
WEFT_HD void membrane_law_gradient_hessian(const Vec3<T> x[3], const Mat2<T>& inv_rest, T area,
                                           const Respond& respond, Vec3<T> g[3],
                                           Mat3<T> h[6]) noexcept {
  const auto m = detail::membrane_strain(x, inv_rest);
  const MembraneResponse<T> r = respond(m.green);
  detail::membrane_forces(m, r.stress, inv_rest, area, g);
  detail::membrane_law_blocks(m, detail::project_semidefinite(r.stress), r.tangent, inv_rest, area,
                              h);
}

}  // namespace weft
