#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// Adds to the velocities that a step starts from what constant forces make of them: P-Cloth eq.
/// (3) has v~ + h f / m wherever it has v~. Reads and writes: its own vertex. Order: independent.
/// Ghosts: none (every rank does all vertices). Flags: none.
template <class T>
struct IntegrateApplyForces {
  Span<const Vec3<T>> accelerations;  ///< [cloth vertices] [m/s^2]
  T h;                                ///< [s]
  Span<Vec3<T>> velocities;           ///< [cloth vertices] [m/s]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(accelerations.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    velocities[v] += h * accelerations[v];
  }
};

}  // namespace weft
