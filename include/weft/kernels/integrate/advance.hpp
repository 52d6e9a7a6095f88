#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

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

  WEFT_HD Index count() const noexcept { return static_cast<Index>(velocities.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    if (fixed[v] == 0) positions[v] = base[v] + h * (velocities[v] + change);
  }
};

}  // namespace weft
