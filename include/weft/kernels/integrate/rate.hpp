#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// velocities = (positions - base) / h, the velocity that the integrator's formula gives a
/// position. Reads: positions, base. Writes: velocities of its own vertex. Order: independent.
/// Ghosts: none (every rank does all vertices). Flags: none.
template <class T>
struct IntegrateRate {
  Span<const Vec3<T>> positions;  ///< [vertices] [m]
  Span<const Vec3<T>> base;       ///< [cloth vertices] [m] x~
  T h;                            ///< [s]
  Span<Vec3<T>> velocities;       ///< [cloth vertices] [m/s]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(velocities.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    velocities[v] = (T(1) / h) * (positions[v] - base[v]);
  }
};

}  // namespace weft
