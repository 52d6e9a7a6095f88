#pragma once

#include <limits>

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/kernels/assemble/membrane.hpp"

namespace weft {

/// What the linear system of a step cannot know of how a triangle stretches.
template <class T>
struct StretchError {
  T elastic;  ///< [J] energy of stretching at the start of the step
  /// [J] Energy of strain that is of second order in the displacements of the step, at the largest
  /// stiffness of the material without its limits.
  T turned;
  /// [J] By how much the energy at the strain limits differs from its second-order expansion about
  /// the start, without regard to the sign. Infinite where a step begins within the limits and ends
  /// outside: they bound strain, however little energy that takes.
  T limited;
};

namespace detail {

/// Columns of the deformation gradient.
template <class T>
struct StretchColumns {
  Vec3<T> c[2];
  WEFT_HD StretchColumns(const Tri& t, const Mat2<T>& inv_rest, Span<const Vec3<T>> x) noexcept {
    const Vec3<T>& origin = x.data()[t.v[0]];
    const Vec3<T> e1 = x.data()[t.v[1]] - origin;
    const Vec3<T> e2 = x.data()[t.v[2]] - origin;
    for (int k = 0; k < 2; ++k) c[k] = e1 * inv_rest(0, k) + e2 * inv_rest(1, k);
  }
  /// Green strain.
  WEFT_HD Symmetric2<T> green() const noexcept {
    return {(dot(c[0], c[0]) - T(1)) / T(2), dot(c[0], c[1]) / T(2),
            (dot(c[1], c[1]) - T(1)) / T(2)};
  }
};

/// Frobenius norm, squared.
template <class T>
WEFT_HD T norm_sq(const Symmetric2<T>& g) noexcept {
  return g.xx * g.xx + T(2) * g.xy * g.xy + g.yy * g.yy;
}

}  // namespace detail

/// Estimates, for every triangle that touches this rank's rows, by how much the motion of a step
/// misses the quadratic model of stretching that the linear system is made of. With F the
/// deformation gradient and D its change, the Green strain changes by sym(F^T D) + D^T D / 2, of
/// which the linear system knows the first term. Compression shares count at the limits. Reads:
/// positions of all corners. Writes: error of its own triangle. Order: independent. Ghosts:
/// positions of all vertices. Flags: none.
template <class T>
struct AssembleStretchError {
  Span<const Tri> triangles;     ///< [n] these as in AssembleMembrane
  Span<const Mat2<T>> inv_rest;  ///< [n] [1/m]
  Span<const T> area;            ///< [n] [m^2]
  Span<const Index> material;    ///< [n]
  Span<const MaterialRow<T>> materials;
  Span<const Vec3<T>> positions_t0;  ///< [m] start of the step
  Span<const Vec3<T>> positions_t1;  ///< [m] its end
  Span<StretchError<T>> error;       ///< [n]
  Span<const T> compression{};       ///< [n] as in AssembleMembrane; empty: 1
  TurnedStart<T> start{};            ///< D counts from where it turns triangles to

  WEFT_HD Index count() const noexcept { return static_cast<Index>(triangles.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const Tri& t = triangles.data()[i];
    const MaterialRow<T>& m = materials.data()[material.data()[i]];
    const detail::StretchColumns<T> before(t, inv_rest.data()[i], positions_t0);
    const detail::StretchColumns<T> after(t, inv_rest.data()[i], positions_t1);
    Vec3<T> d[2] = {after.c[0] - before.c[0], after.c[1] - before.c[1]};
    const T stiffness = m.stiffness();
    Vec3<T> turned[2];
    if (start.edges(t, inv_rest.data()[i], stiffness, m.density, turned))
      for (int k = 0; k < 2; ++k)
        d[k] = after.c[k] -
               (turned[0] * inv_rest.data()[i](0, k) + turned[1] * inv_rest.data()[i](1, k));
    const detail::Symmetric2<T> second{dot(d[0], d[0]), dot(d[0], d[1]), dot(d[1], d[1])};
    const T rest_area = area.data()[i];
    const detail::Symmetric2<T> green = before.green();
    StretchError<T> e;
    e.elastic = rest_area * stiffness / T(2) * detail::norm_sq(green);
    e.turned = rest_area * stiffness / T(8) * detail::norm_sq(second);
    e.limited = T(0);
    if (m.limits.any()) {
      const T beta = compression.empty() ? T(1) : compression.data()[i];
      const detail::Symmetric2<T> seen_t0 = buckled_strain(green, beta);
      const detail::Symmetric2<T> seen_t1 = buckled_strain(after.green(), beta);
      const MembraneLimits<T> limits = m.limits.of_triangle(rest_area);
      e.elastic += rest_area * limits.energy(seen_t0);
      e.limited = limits.holds(seen_t0) && !limits.holds(seen_t1)
                      ? std::numeric_limits<T>::infinity()
                      : rest_area * limits.expansion_error(seen_t0, seen_t1);
    }
    error.data()[i] = e;
  }
};

}  // namespace weft
