#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {

/// Takes over what the impact zones decided: positions, and of cloth the velocities that belong to
/// them.
/// Reads: moved. Writes: positions, velocities, marks of moved vertices. Order: independent, each
/// vertex appears once. Ghosts: none (every rank applies all). Flags: none.
template <class T>
struct RespondApply {
  Span<const MovedVertex<T>> moved;
  Span<const Vec3<T>> base;              ///< [cloth vertices] [m] x~
  T h;                                   ///< [s]
  Span<Vec3<T>> positions;               ///< [vertices] [m]
  Span<Vec3<T>> velocities;              ///< [cloth vertices] [m/s]
  Span<unsigned char> moved_now;         ///< [vertices] set to 1: moved in this round
  Span<unsigned char> moved_in_attempt;  ///< [vertices] set to 1

  WEFT_HD Index count() const noexcept { return static_cast<Index>(moved.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const MovedVertex<T>& m = moved[static_cast<std::size_t>(i)];
    const auto v = static_cast<std::size_t>(m.vertex);
    positions[v] = m.position;
    if (v < velocities.size()) velocities[v] = (T(1) / h) * (m.position - base[v]);
    moved_now[v] = 1;
    moved_in_attempt[v] = 1;
  }
};

}  // namespace weft
