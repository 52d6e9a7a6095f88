#pragma once

#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/state/row_blocks.hpp"

namespace weft {

/// What multiplies the velocity of a row's own vertex alone, whatever the others do. All other
/// terms of the mesh's part of the matrix act between vertices, so their rows sum to zero, and
/// products take them from differences: see docs/decisions/003-linear-solve.md.
template <class T>
struct VertexPart {
  Span<const T> mass;       ///< [rows] [kg] m (1 + h a)
  RowBlocks<const T> drag;  ///< [kg] of the air; empty: none
};

}  // namespace weft
