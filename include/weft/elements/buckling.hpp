#pragma once

#include "weft/elements/membrane_law.hpp"
#include "weft/elements/scalar.hpp"

// Folds that a coarse triangle cannot form, as a law that yields to compression (Koh, Narain and
// O'Brien 2015, section 3.5). With g1 >= g2 the eigenvalues of the Green strain G, any law sees
//   seen(G) = f(g1) q1 q1^T + f(g2) q2 q2^T,  f(g) = g if g >= 0, beta g if not   (eq. 10)
// and the energy is W(seen(G)), whose derivatives go through `seen`. Where g1 >= 0 > g2, in the
// frame of q1, q2, with r = (g1 - g2) / 2 and h = (g1 - beta g2) / (g1 - g2),
//   d seen / dG = diag(1, beta, h) on (G11, G22, G12)
// and `seen` turns with the frame, which adds to the second derivative. As f has a kink, so may
// the force: where a law couples its directions and g passes zero.

// Inlined into a kernel this would cost all triangles what few need.
#if defined(__CUDACC__)
#define WEFT_OUT_OF_LINE __noinline__
#else
#define WEFT_OUT_OF_LINE
#endif

namespace weft {

/// Strain that a law sees.
/// @param beta [0, 1] share of a compression that is left
/// @cite koh2015, eq. (10)
template <class T>
WEFT_HD detail::Symmetric2<T> buckled_strain(const detail::Symmetric2<T>& g, T beta) noexcept {
  using std::sqrt;
  const T mean = (g.xx + g.yy) / T(2);
  const T half = (g.xx - g.yy) / T(2);
  const T radius = sqrt(half * half + g.xy * g.xy);
  if (mean >= radius || beta == T(1)) return g;
  if (mean < -radius) return {beta * g.xx, beta * g.xy, beta * g.yy};
  const T low = beta * (mean - radius);
  const T seen_mean = (mean + radius + low) / T(2);
  const T scale = (mean + radius - low) / (T(2) * radius);
  return {seen_mean + scale * half, scale * g.xy, seen_mean - scale * half};
}

namespace detail {

/// Symmetric 3x3 matrix in two frames: A^T m A, the upper half row by row.
template <class T>
WEFT_HD void congruent(const T a[9], T m[6]) noexcept {
  const T full[9] = {m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5]};
  T half[9];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      half[3 * i + j] =
          full[3 * i] * a[j] + full[3 * i + 1] * a[3 + j] + full[3 * i + 2] * a[6 + j];
  int k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      m[k++] = a[i] * half[j] + a[3 + i] * half[3 + j] + a[6 + i] * half[6 + j];
}

}  // namespace detail

/// Turns a law's response at buckled_strain(g, beta) into the derivatives with respect to g.
/// @param project what of the second derivative of `seen` is indefinite is left out, so that a
///                positive semi-definite tangent stays one
template <class T>
WEFT_OUT_OF_LINE WEFT_HD void carry_buckling(const detail::Symmetric2<T>& g, T beta, bool project,
                                             MembraneResponse<T>& r) noexcept {
  using std::sqrt;
  const T mean = (g.xx + g.yy) / T(2);
  const T half = (g.xx - g.yy) / T(2);
  const T radius = sqrt(half * half + g.xy * g.xy);
  if (mean >= radius || beta == T(1)) return;
  if (mean < -radius) {
    r.stress = {beta * r.stress.xx, beta * r.stress.xy, beta * r.stress.yy};
    for (T& k : r.tangent) k *= beta * beta;
    return;
  }
  // Twice the angle from the warp to q1.
  const T c = half / radius, s = g.xy / radius;
  const T big = (T(1) + c) / T(2), small = (T(1) - c) / T(2);
  const T strain_to[9] = {big, small, s / T(2), small, big, -s / T(2), -s, s, c};
  const T stress_back[9] = {big, small, -s / T(2), small, big, s / T(2), s, -s, c};  // sigma_to^T
  detail::Symmetric2<T>& z = r.stress;
  const T along = big * z.xx + small * z.yy + s * z.xy;
  const T across = small * z.xx + big * z.yy - s * z.xy;
  const T shear = s / T(2) * (z.yy - z.xx) + c * z.xy;
  const T h = (mean + radius - beta * (mean - radius)) / (T(2) * radius);
  T* k = r.tangent;
  detail::congruent(stress_back, k);
  k[1] *= beta;
  k[2] *= h;
  k[3] *= beta * beta;
  k[4] *= beta * h;
  k[5] *= h * h;
  // Second derivatives of `seen`, on (G11, G22, 2 G12).
  const T turn = (T(1) - beta) / (T(2) * radius);        // how the mean of f(g) follows the frame
  const T change = ((T(1) + beta) / T(2) - h) / radius;  // dh / dr
  const T twist = ((along + across) * turn + (along - across) * change) / T(4);
  k[5] += project && twist < T(0) ? T(0) : twist;
  if (!project) {
    k[2] += shear * (turn + change) / T(2);
    k[4] += shear * (turn - change) / T(2);
  }
  detail::congruent(strain_to, k);
  const T low = beta * across, mixed = h * shear;
  z = {big * along + small * low - s * mixed, s / T(2) * (along - low) + c * mixed,
       small * along + big * low + s * mixed};
}

/// A law that yields to compression, in the sense of membrane_law.hpp.
template <class T, class Law>
struct BuckledLaw {
  Law law;
  T beta;

  WEFT_HD T energy(const detail::Symmetric2<T>& g) const noexcept {
    return law.energy(buckled_strain(g, beta));
  }
  WEFT_HD MembraneResponse<T> response(const detail::Symmetric2<T>& g,
                                       bool project) const noexcept {
    MembraneResponse<T> r = law.response(buckled_strain(g, beta), project);
    carry_buckling(g, beta, project, r);
    return r;
  }
};

}  // namespace weft

#undef WEFT_OUT_OF_LINE
