#pragma once

#include <array>
#include <vector>

#include "weft/core/ids.hpp"

namespace weft {

/// Adds the two triangles of a cell with these corners, in the order around it. They meet in the
/// diagonal from the first corner to the third, of a mirrored cell in the other one.
inline void add_cell(std::vector<Tri>& triangles, const std::array<Index, 4>& c, bool mirrored) {
  if (mirrored) {
    triangles.push_back({{c[0], c[1], c[3]}});
    triangles.push_back({{c[1], c[2], c[3]}});
  } else {
    triangles.push_back({{c[0], c[1], c[2]}});
    triangles.push_back({{c[0], c[2], c[3]}});
  }
}

}  // namespace weft
