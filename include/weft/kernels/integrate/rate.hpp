#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

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
};

template <class T>
WEFT_HD void integrate_rate(const IntegrateRate<T>& a, Index i) noexcept {
  const auto v = static_cast<std::size_t>(i);
  a.velocities[v] = (T(1) / a.h) * (a.positions[v] - a.base[v]);
}

template <class T>
void run(OnHost, Queue& queue, const IntegrateRate<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const IntegrateRate<T>& args);

}  // namespace weft
