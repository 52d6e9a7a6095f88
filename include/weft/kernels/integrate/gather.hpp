#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

namespace weft {

/// Copies what chosen vertices have, for the host to read. Reads: values. Writes: its own place.
/// Order: independent. Ghosts: chosen vertices. Flags: none.
template <class T>
struct IntegrateGather {
  Span<const Index> vertices;  ///< [n]
  Span<const Vec3<T>> values;  ///< [vertices]
  Span<Vec3<T>> gathered;      ///< [n]
};

template <class T>
WEFT_HD void integrate_gather(const IntegrateGather<T>& a, Index i) noexcept {
  const auto n = static_cast<std::size_t>(i);
  a.gathered[n] = a.values[static_cast<std::size_t>(a.vertices[n])];
}

template <class T>
void run(OnHost, Queue& queue, const IntegrateGather<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const IntegrateGather<T>& args);

}  // namespace weft
