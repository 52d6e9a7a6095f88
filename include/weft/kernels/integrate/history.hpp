#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/state/touched.hpp"

namespace weft {

/// Base state of BDF2 with variable steps: with q = h_n / h_(n-1) and c0 = (1 + 2 q) / (1 + q),
///   x~ = ((1 + q) x_n - q^2 / (1 + q) x_(n-1)) / c0, and v~ in the same way,
/// a step of BDF2 is one of implicit Euler of length h_n / c0 from (x~, v~).
/// A vertex that an impact zone moved in the last step restarts from (x_n, v_n) extrapolated
/// along its velocity: its history knows nothing of the impact.
/// Reads: two past states. Writes: base state of its own vertex. Order: independent. Ghosts: none.
template <class T>
struct IntegrateHistory {
  Span<const Vec3<T>> positions;            ///< [cloth vertices] [m] x_n
  Span<const Vec3<T>> velocities;           ///< [m/s] v_n
  Span<const Vec3<T>> previous_positions;   ///< [m] x_(n-1)
  Span<const Vec3<T>> previous_velocities;  ///< [m/s] v_(n-1)
  Span<const unsigned char> touched;        ///< [vertices] see state/touched.hpp
  T ratio;                                  ///< q
  T previous_step;                          ///< [s] h_(n-1)
  Span<Vec3<T>> base_positions;             ///< [m] x~
  Span<Vec3<T>> base_velocities;            ///< [m/s] v~

  WEFT_HD Index count() const noexcept { return static_cast<Index>(velocities.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    const T q = ratio;
    // x~ = x_n + s (x_n - x_(n-1)) with s = q^2 / (1 + 2 q): differences keep the digits that
    // count.
    const T s = q * q / (T(1) + T(2) * q);
    const bool restarts = was_touched(touched[v]);
    const Vec3<T> dx =
        restarts ? previous_step * velocities[v] : positions[v] - previous_positions[v];
    const Vec3<T> dv = restarts ? Vec3<T>{} : velocities[v] - previous_velocities[v];
    base_positions[v] = positions[v] + s * dx;
    base_velocities[v] = velocities[v] + s * dv;
  }
};

}  // namespace weft
