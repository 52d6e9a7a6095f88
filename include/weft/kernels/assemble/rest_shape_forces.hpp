#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/triangle_frame.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// How the triangles of plates that are curved at rest have turned, and what their turning asks of
/// their corners: the part of the gradient of PlateShape's energy (host/model/plate.hpp) that comes
/// from the rotations. Reads: positions of the triangles' corners and of the vertices around them.
/// Writes: axes and corner_force of its own triangle. Order: entries as stored. Ghosts: positions.
/// Flags: none.
template <class T>
struct AssembleRestShapeForces {
  Span<const Tri> corners;
  Span<const Mat2<T>> inv_rest;   ///< [1/m]
  Span<const Offset> offset;      ///< [triangles + 1] into vertex and force
  Span<const Index> vertex;       ///< of an entry
  Span<const Vec3<T>> force;      ///< [N] of an entry, in the triangle's frame
  Span<const Vec3<T>> positions;  ///< [m] iterate x_k
  Span<Vec3<T>> axes;             ///< [3 triangles] of its frame
  Span<Vec3<T>> corner_force;     ///< [3 triangles] [N]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(corners.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto t = static_cast<std::size_t>(i);
    Vec3<T> x[3];
    for (int j = 0; j < 3; ++j) x[j] = positions[static_cast<std::size_t>(corners[t].v[j])];
    const TriangleFrame<T> frame = triangle_frame(x, inv_rest[t]);
    // Forces sum to zero: torques about any point are the same.
    Vec3<T> torque{};
    for (auto e = static_cast<std::size_t>(offset[t]); e < static_cast<std::size_t>(offset[t + 1]);
         ++e)
      torque +=
          cross(from_frame(frame, force[e]), positions[static_cast<std::size_t>(vertex[e])] - x[0]);
    triangle_frame_gradient(frame, inv_rest[t], torque, &corner_force[3 * t]);
    for (std::size_t j = 0; j < 3; ++j) axes[3 * t + j] = frame.axis[j];
  }
};

}  // namespace weft
