#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

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
};

template <class T>
WEFT_HD void integrate_update(const IntegrateUpdate<T>& a, Index i) noexcept {
  const auto v = static_cast<std::size_t>(a.row_begin + i);
  a.velocities[v] = (a.iterate.empty() ? Vec3<T>{} : a.iterate[v]) + a.share * a.dv[v];
}

template <class T>
void run(OnHost, Queue& queue, const IntegrateUpdate<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const IntegrateUpdate<T>& args);

}  // namespace weft
