#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

namespace weft {

/// positions = base + h (velocities + change) for the cloth vertices; fixed ones keep what they
/// hold. Reads: velocities, base. Writes: positions of its own vertex. Order: independent. Ghosts:
/// none (every rank advances all vertices). Flags: none.
template <class T>
struct IntegrateAdvance {
  Span<const Vec3<T>> base;         ///< [cloth vertices] [m] x~
  Span<const Vec3<T>> velocities;   ///< [cloth vertices] [m/s]
  Span<const unsigned char> fixed;  ///< [cloth vertices]
  T h;                              ///< [s]
  Span<Vec3<T>> positions;          ///< [vertices] [m]
  Vec3<T> change{};                 ///< [m/s] of every velocity
};

template <class T>
WEFT_HD void integrate_advance(const IntegrateAdvance<T>& a, Index i) noexcept {
  const auto v = static_cast<std::size_t>(i);
  if (a.fixed[v] == 0) a.positions[v] = a.base[v] + a.h * (a.velocities[v] + a.change);
}

template <class T>
void run(OnHost, Queue& queue, const IntegrateAdvance<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const IntegrateAdvance<T>& args);

}  // namespace weft
