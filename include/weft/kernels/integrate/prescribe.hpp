#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/moved_vertex.hpp"

namespace weft {

/// Puts pinned vertices where their pins want them at the end of the step.
/// Reads: targets. Writes: positions. Order: independent, each vertex appears once. Ghosts: none
/// (every rank places all). Flags: none.
template <class T>
struct IntegratePrescribe {
  Span<const MovedVertex<T>> targets;
  Span<Vec3<T>> positions;  ///< [vertices] [m]
};

template <class T>
WEFT_HD void integrate_prescribe(const IntegratePrescribe<T>& a, Index i) noexcept {
  const MovedVertex<T>& m = a.targets[static_cast<std::size_t>(i)];
  a.positions[static_cast<std::size_t>(m.vertex)] = m.position;
}

template <class T>
void run(OnHost, Queue& queue, const IntegratePrescribe<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const IntegratePrescribe<T>& args);

}  // namespace weft
