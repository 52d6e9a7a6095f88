#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// World positions of vertices in the order of the input. Several may be of one vertex. Reads:
/// positions. Writes: its own place. Order: independent. Ghosts: chosen vertices. Flags: none.
template <class T>
struct IntegrateWorldPositions {
  Span<const Index> vertices;     ///< [n]
  Span<const Vec3<T>> positions;  ///< [vertices] [m] relative to origin
  Vec3<double> origin;            ///< [m]
  Span<Vec3<float>> world;        ///< [n] [m]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(vertices.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto n = static_cast<std::size_t>(i);
    const Vec3<T>& x = positions[static_cast<std::size_t>(vertices[n])];
    world[n] = vec_cast<float>(vec_cast<double>(x) + origin);
  }
};

}  // namespace weft
