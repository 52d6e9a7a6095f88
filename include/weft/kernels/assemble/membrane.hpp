#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/buckling.hpp"
#include "weft/elements/membrane_measured.hpp"
#include "weft/elements/strain_limit.hpp"
#include "weft/elements/turned_start.hpp"
#include "weft/exec/launch.hpp"

namespace weft {

/// Which law a material stretches by. Isotropic ones with limits go as orthotropic.
enum class MembraneKind : Index { isotropic, orthotropic, samples, ridges };

/// What the membrane kernel needs to know of a material.
template <class T>
struct MaterialRow {
  MembraneConstants<T> membrane;  ///< of isotropic ones
  T damping_stiffness;            ///< [s] Rayleigh b
  MembraneKind kind = MembraneKind::isotropic;
  OrthotropicMembrane<T> orthotropic{};  ///< of isotropic ones too
  Index table = 0;             ///< of samples and ridges: where theirs begins in the tables
  MembraneLimits<T> limits{};  ///< none of isotropic ones
  T density = T(0);            ///< [kg/m^2]

  /// The largest without limits. [N/m]
  WEFT_HD T stiffness() const noexcept {
    return kind == MembraneKind::orthotropic ? greater(orthotropic.c11, orthotropic.c22)
                                             : membrane.lambda + T(2) * membrane.mu;
  }
};

/// Elastic and damping forces of every triangle that touches this rank's rows, and their projected
/// Jacobian, both scaled for the velocity system (M - h^2 J) dv = h f.
/// Reads: positions and velocities of all corners. Writes: gradient, block of its own triangle.
/// Order: independent. Ghosts: positions and velocities of all vertices. Flags: none.
template <class T>
struct AssembleMembrane {
  Span<const Tri> triangles;     ///< [n] global vertex numbers
  Span<const Mat2<T>> inv_rest;  ///< [n] [1/m]
  Span<const T> area;            ///< [n] [m^2] at rest
  Span<const Index> material;    ///< [n] into materials
  Span<const MaterialRow<T>> materials;
  Span<const Vec3<T>> positions;   ///< [m] iterate x_k
  Span<const Vec3<T>> velocities;  ///< [m/s] iterate v_k; empty: zero
  T h;                             ///< [s] effective time step
  Span<Vec3<T>> impulse;           ///< [3n] [N s] h f of each corner
  Span<Mat3<T>> block;             ///< [6n] [kg] h (h + b) K, blocks 00 01 02 11 12 22
  Span<const T> tables{};          ///< of materials that have one, one after the other
  /// [n] share of a compression that the material sees, see buckling.hpp; empty: 1
  Span<const T> compression{};
  /// Triangles that it turns are linearised where they are then. Without velocities, h is the time
  /// step, and x_k is reached within it.
  TurnedStart<T> start{};
};

/// Gradient and projected Hessian of one triangle of any material.
template <class T>
WEFT_HD void membrane_of_material(const AssembleMembrane<T>& a, const MaterialRow<T>& m,
                                  const Vec3<T> x[3], std::size_t n, Vec3<T> g[3],
                                  Mat3<T> h[6]) noexcept {
  const T beta = a.compression.empty() ? T(1) : a.compression[n];
  if (m.kind == MembraneKind::isotropic && !(beta < T(1))) {
    membrane_gradient_hessian(x, a.inv_rest[n], a.area[n], m.membrane, g, h);
    return;
  }
  const auto respond_unlimited = [&](const detail::Symmetric2<T>& green) {
    if (m.kind == MembraneKind::orthotropic || m.kind == MembraneKind::isotropic)
      return m.orthotropic.response(green, true);
    const T* table = a.tables.data() + m.table;
    return m.kind == MembraneKind::samples ? MembraneSamples<T>{table}.response(green, true)
                                           : MembraneRidges<T>{table}.response(green, true);
  };
  const auto respond = [&](const detail::Symmetric2<T>& green) {
    const detail::Symmetric2<T> seen = beta < T(1) ? buckled_strain(green, beta) : green;
    MembraneResponse<T> r = respond_unlimited(seen);
    if (m.limits.any()) m.limits.of_triangle(a.area[n]).add(seen, r);
    if (beta < T(1)) carry_buckling(green, beta, true, r);
    return r;
  };
  membrane_law_gradient_hessian(x, a.inv_rest[n], a.area[n], respond, g, h);
}

/// What triangle i writes, to wherever the caller has it.
/// @param impulse [3]
/// @param k       [6]
template <class T>
WEFT_HD void membrane_terms(const AssembleMembrane<T>& a, Index i, Vec3<T>* impulse,
                            Mat3<T>* k) noexcept {
  const auto n = static_cast<std::size_t>(i);
  const Tri& t = a.triangles[n];
  const MaterialRow<T>& m = a.materials[static_cast<std::size_t>(a.material[n])];
  Vec3<T> x[3];
  for (int c = 0; c < 3; ++c) x[c] = a.positions[static_cast<std::size_t>(t.v[c])];
  Vec3<T> g[3], turned[2];
  if (a.start.edges(t, a.inv_rest[n], m.stiffness(), m.density, turned)) {
    const Vec3<T> about[3] = {Vec3<T>{}, turned[0], turned[1]};
    membrane_of_material(a, m, about, n, g, k);
    const T share = a.velocities.empty() ? T(1) + m.damping_stiffness / a.h : T(1);
    const Vec3<T> d1 = share * ((x[1] - x[0]) - turned[0]);
    const Vec3<T> d2 = share * ((x[2] - x[0]) - turned[1]);
    const Vec3<T> g1 = k[3] * d1 + k[4] * d2;
    const Vec3<T> g2 = transpose(k[4]) * d1 + k[5] * d2;
    g[0] -= g1 + g2;
    g[1] += g1;
    g[2] += g2;
  } else {
    membrane_of_material(a, m, x, n, g, k);
  }
  if (!a.velocities.empty() && m.damping_stiffness > T(0)) {
    Vec3<T> v[3];
    for (int c = 0; c < 3; ++c)
      v[c] = m.damping_stiffness * a.velocities[static_cast<std::size_t>(t.v[c])];
    g[0] += k[0] * v[0] + k[1] * v[1] + k[2] * v[2];
    g[1] += transpose(k[1]) * v[0] + k[3] * v[1] + k[4] * v[2];
    g[2] += transpose(k[2]) * v[0] + transpose(k[4]) * v[1] + k[5] * v[2];
  }
  for (int c = 0; c < 3; ++c) impulse[c] = -a.h * g[c];
  const T scale = a.h * (a.h + m.damping_stiffness);
  for (int b = 0; b < 6; ++b) k[b] *= scale;
}

template <class T>
WEFT_HD void assemble_membrane(const AssembleMembrane<T>& a, Index i) noexcept {
  const auto n = static_cast<std::size_t>(i);
  membrane_terms(a, i, a.impulse.data() + 3 * n, a.block.data() + 6 * n);
}

template <class T>
void run(OnHost, Queue& queue, const AssembleMembrane<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const AssembleMembrane<T>& args);

}  // namespace weft
