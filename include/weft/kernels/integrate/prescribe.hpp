#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/state/moved_vertex.hpp"

namespace weft {

/// Puts pinned vertices where their pins want them at the end of the step.
/// Reads: targets. Writes: positions. Order: independent, each vertex appears once. Ghosts: none
/// (every rank places all). Flags: none.
template <class T>
struct IntegratePrescribe {
  Span<const MovedVertex<T>> targets;
  Span<Vec3<T>> positions;  ///< [vertices] [m]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(targets.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const MovedVertex<T>& m = targets[static_cast<std::size_t>(i)];
    positions[static_cast<std::size_t>(m.vertex)] = m.position;
  }
};

}  // namespace weft
