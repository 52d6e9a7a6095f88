#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/state/touched.hpp"

namespace weft {

/// Updates the record of what impact zones and crushed contacts do to vertices, at the end of a
/// step. Reads: moved, crushed, crushed_in_jam. Writes: touched of its own vertex. Order:
/// independent. Ghosts: none (every rank updates all). Flags: none.
struct RespondRemember {
  Span<const unsigned char> moved;    ///< [vertices] 1: moved by a zone in this attempt
  Span<const unsigned char> crushed;  ///< [vertices] this and the next as AssembleContactCache
                                      ///< leaves them, obstacles': 0
  Span<const unsigned char> crushed_in_jam;
  Hardening hardening;
  Span<unsigned char> touched;  ///< [vertices] see state/touched.hpp

  WEFT_HD Index count() const noexcept { return static_cast<Index>(touched.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    const bool has_level = touched_level(touched[v]) > 0;
    const bool hit = moved[v] != 0 && (has_level || hardening >= Hardening::all);
    const bool pressed =
        crushed[v] != 0 && (has_level || crushed_in_jam[v] != 0 || hardening >= Hardening::crushed);
    touched[v] =
        touched_after(touched[v], moved[v] != 0, hardening != Hardening::none && (hit || pressed));
  }
};

}  // namespace weft
