#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/pressure.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// Pressure on every triangle, where the iterate is, added to what AssembleMembrane wrote.
///
/// It adds nothing to the matrix. Summed over a closed surface its Jacobian S is symmetric and its
/// diagonal blocks are zero: it is indefinite. What is positive in -S of each triangle could be
/// kept, but that would hold back rigid motions and cost the surface its momentum.
/// Without S the matrix stays definite, and little is lost. A linearly implicit step that leaves S
/// out of the stiffness A = K - S is stable where A and 4 M / h^2 + K + S are positive definite. S
/// couples motion along the normal with stretch in the plane, so mirroring the latter turns K + S
/// into K - S, up to curvature: the step is stable where the cloth itself is. Where both are
/// definite Newton's iteration converges as well, the faster the less the pressure stretches.
///
/// Reads: positions of all corners. Writes: impulse of its own triangle (adds). Order: independent.
/// Ghosts: positions of all vertices. Flags: none.
template <class T>
struct AssemblePressure {
  Span<const Tri> triangles;      ///< [n] global vertex numbers
  Span<const T> pressure;         ///< [n] [Pa]
  Span<const Vec3<T>> positions;  ///< [m] iterate x_k
  T h;                            ///< [s] effective time step
  Span<Vec3<T>> impulse;          ///< [3n] [N s] as in AssembleMembrane

  WEFT_HD Index count() const noexcept { return static_cast<Index>(triangles.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto n = static_cast<std::size_t>(i);
    const Tri& t = triangles[n];
    Vec3<T> x[3];
    for (int c = 0; c < 3; ++c) x[c] = positions[static_cast<std::size_t>(t.v[c])];
    const Vec3<T> share = h * pressure_on_corner(x, pressure[n]);
    for (std::size_t c = 0; c < 3; ++c) impulse[3 * n + c] += share;
  }
};

}  // namespace weft
