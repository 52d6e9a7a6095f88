#pragma once

#include "weft/core/ids.hpp"

namespace weft {

/// Whether a triangle has this vertex.
constexpr bool has(const Tri& t, Index v) {
  return t.v[0] == v || t.v[1] == v || t.v[2] == v;
}

}  // namespace weft
