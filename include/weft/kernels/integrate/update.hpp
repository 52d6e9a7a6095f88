#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// New velocities of one rank's rows: the iterate plus a share of the solution.
/// Reads: iterate, dv. Writes: velocities of its own row. Order: independent. Ghosts: none.
template <class T>
struct IntegrateUpdate {
  Index row_begin = 0;
  Index row_count = 0;
  Span<const Vec3<T>> iterate;  ///< [cloth vertices] [m/s] v_k; empty: zero
  Span<const Vec3<T>> dv;       ///< [vertices] [m/s]
  T share;                      ///< [1] step length of the line search
  Span<Vec3<T>> velocities;     ///< [cloth vertices] [m/s]

  WEFT_HD Index count() const noexcept { return row_count; }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(row_begin + i);
    velocities[v] = (iterate.empty() ? Vec3<T>{} : iterate[v]) + share * dv[v];
  }
};

}  // namespace weft
