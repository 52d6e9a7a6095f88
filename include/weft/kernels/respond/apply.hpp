#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {

/// Takes over what the impact zones decided: positions, and of cloth the velocities that belong to
/// them.
/// Reads: moved. Writes: positions, velocities, marks of moved vertices. Order: independent, each
/// vertex appears once. Ghosts: none (every rank applies all). Flags: none.
template <class T>
struct RespondApply {
  Span<const MovedVertex<T>> moved;
  Span<const Vec3<T>> base;       ///< [cloth vertices] [m] x~
  T h;                            ///< [s]
  Span<Vec3<T>> positions;        ///< [vertices] [m]
  Span<Vec3<T>> velocities;       ///< [cloth vertices] [m/s]
  Span<unsigned char> moved_now;  ///< [vertices] set to 1: moved in this round
  Span<unsigned char> touched;    ///< [vertices] set to 1: moved in this step
};

template <class T>
WEFT_HD void respond_apply(const RespondApply<T>& a, Index i) noexcept {
  const MovedVertex<T>& m = a.moved[static_cast<std::size_t>(i)];
  const auto v = static_cast<std::size_t>(m.vertex);
  a.positions[v] = m.position;
  if (v < a.velocities.size()) a.velocities[v] = (T(1) / a.h) * (m.position - a.base[v]);
  a.moved_now[v] = 1;
  a.touched[v] = 1;
}

template <class T>
void run(OnHost, Queue& queue, const RespondApply<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const RespondApply<T>& args);

}  // namespace weft
