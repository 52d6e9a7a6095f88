#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/state/touched.hpp"

namespace weft {

/// Updates the record of what impact zones do to vertices, at the end of a step.
/// Reads: moved. Writes: touched of its own vertex. Order: independent. Ghosts: none (every rank
/// updates all). Flags: none.
struct RespondRemember {
  Span<const unsigned char> moved;  ///< [vertices] 1: moved by a zone in this step
  bool raise;                       ///< whether that raises levels
  Span<unsigned char> touched;      ///< [vertices] see state/touched.hpp

  WEFT_HD Index count() const noexcept { return static_cast<Index>(touched.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    touched[v] = touched_after(touched[v], moved[v] != 0, raise);
  }
};

}  // namespace weft
