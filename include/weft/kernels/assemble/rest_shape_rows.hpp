#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// The impulse h f on the rows of one rank that a plate's curved rest shape adds: the forces that
/// keep it, turned with their triangles, and those of the turning itself. Reads: axes and
/// corner_force of the triangles. Writes: rhs of its own row (adds). Order: entries ascending, then
/// corners ascending. Ghosts: none. Flags: none.
template <class T>
struct AssembleRestShapeRows {
  Index row_count = 0;
  Span<const Offset> entry_offset;   ///< [rows + 1] into entry
  Span<const Index> entry;           ///< into force
  Span<const Index> entry_triangle;  ///< of a force
  Span<const Vec3<T>> force;         ///< [N] in the triangle's frame
  Span<const Offset> corner_offset;  ///< [rows + 1] into corner
  Span<const Index> corner;          ///< 3 triangle + corner
  Span<const Vec3<T>> axes;          ///< [3 triangles]
  Span<const Vec3<T>> corner_force;  ///< [3 triangles] [N]
  T h;                               ///< [s] effective time step
  Span<Vec3<T>> rhs;                 ///< [rows] [N s]

  WEFT_HD Index count() const noexcept { return row_count; }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto row = static_cast<std::size_t>(i);
    Vec3<T> sum{};
    for (auto n = static_cast<std::size_t>(entry_offset[row]);
         n < static_cast<std::size_t>(entry_offset[row + 1]); ++n) {
      const auto e = static_cast<std::size_t>(entry[n]);
      const std::size_t axis = 3 * static_cast<std::size_t>(entry_triangle[e]);
      sum += axes[axis] * force[e][0] + axes[axis + 1] * force[e][1] + axes[axis + 2] * force[e][2];
    }
    for (auto n = static_cast<std::size_t>(corner_offset[row]);
         n < static_cast<std::size_t>(corner_offset[row + 1]); ++n)
      sum += corner_force[static_cast<std::size_t>(corner[n])];
    rhs[row] += h * sum;
  }
};

}  // namespace weft
