#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// Vertices of a component of cloth whose mean velocity is taken for that of the piece as a whole.
constexpr int moving_frame_samples = 16;

/// First iterate of the linearly implicit step: every component of cloth where it starts, moved
/// along by its drift V, a mean velocity: x_k = x_n + dt V, v_k = V. No element sees a translation,
/// so that the solution about x_k is that about x_n; but it is v_{n+1} - V that is solved for. Its
/// differences between neighbours would be rounded in proportion to V otherwise, and stretching of
/// small triangles that fly multiplies that to more than their weight.
/// Reads: velocities of the samples, position of its own vertex. Writes: iterate of its own vertex.
/// Order: samples in their order. Ghosts: none (every rank does all vertices). Flags: none.
template <class T>
struct IntegrateMovingFrame {
  Span<const Vec3<T>> positions;          ///< [cloth vertices] [m] x_n
  Span<const Vec3<T>> velocities;         ///< [all cloth vertices] [m/s] v_n
  Span<const Index> component_of_vertex;  ///< [cloth vertices]
  Span<const Index> sample;               ///< [moving_frame_samples * pieces] vertices
  T dt;                                   ///< [s]
  Span<Vec3<T>> iterate_positions;        ///< [cloth vertices] [m] x_k
  Span<Vec3<T>> iterate_velocities;       ///< [cloth vertices] [m/s] v_k

  WEFT_HD Index count() const noexcept { return static_cast<Index>(component_of_vertex.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(i);
    const auto first = static_cast<std::size_t>(component_of_vertex[v]) *
                       static_cast<std::size_t>(moving_frame_samples);
    Vec3<T> sum{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(moving_frame_samples); ++k)
      sum += velocities[static_cast<std::size_t>(sample[first + k])];
    const Vec3<T> drift = (T(1) / T(moving_frame_samples)) * sum;
    iterate_positions[v] = positions[v] + dt * drift;
    iterate_velocities[v] = drift;
  }
};

}  // namespace weft
