#pragma once

#include <cstddef>

#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Ball around the displacements of a primitive's corners. [m]
template <class T>
struct DisplacementBall {
  Vec3<T> centre;
  T radius;
};

/// How a primitive has moved since its pairs were measured, and how it moves in the prediction.
template <class T>
struct PrimitiveMotion {
  DisplacementBall<T> before, ahead;
};

/// Lower bounds of the pairs' distances at given positions, plus what any two primitives may have
/// closed in between the search and then. With them a later call skips pairs that cannot have come
/// close. On the host only.
template <class T>
struct KnownDistances {
  Span<float> faces, edges;          ///< [capacity of the pairs] [m]; empty: not kept
  Span<Vec3<T>> positions;           ///< [vertices] [m] at which they are bounds
  Span<float> closed;                ///< [1] [m] that is in them
  Span<PrimitiveMotion<T>> motions;  ///< scratch [vertices + edges + faces]
  bool hold = false;                 ///< false: the pairs are new, nothing is known of them
  std::size_t turn = 0;  ///< number of the call: every call measures another part of the pairs
};

}  // namespace weft
