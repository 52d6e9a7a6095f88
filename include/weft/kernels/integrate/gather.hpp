#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// Copies what chosen vertices have, for the host to read. Reads: values. Writes: its own place.
/// Order: independent. Ghosts: chosen vertices. Flags: none.
template <class T>
struct IntegrateGather {
  Span<const Index> vertices;  ///< [n]
  Span<const Vec3<T>> values;  ///< [vertices]
  Span<Vec3<T>> gathered;      ///< [n]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(vertices.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto n = static_cast<std::size_t>(i);
    gathered[n] = values[static_cast<std::size_t>(vertices[n])];
  }
};

}  // namespace weft
