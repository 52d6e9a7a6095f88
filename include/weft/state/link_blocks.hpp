#pragma once

#include "weft/state/contact_operator.hpp"

namespace weft {

/// What a corner of a link adds to a matrix of aggregates, as multiples of the link's block. All
/// corners in an aggregate move as one, and the first of them that has a weight adds for all.
template <class T>
struct LinkBlocks {
  static constexpr int nowhere = -1;
  T weight[4] = {};  ///< of the block at place[n]; 0: nothing

  /// @param vertex of the corner that adds
  /// @param place  of the blocks of its aggregate and that of each corner, or nowhere
  /// @param own    place of the block of its aggregate on the diagonal
  WEFT_HD static LinkBlocks of(const ContactOperatorEntry<T>& link, Index vertex,
                               const int (&place)[4], int own) noexcept {
    LinkBlocks blocks;
    int first = 0;
    while (first < 4 && !(place[first] == own && link.w[first] != T(0))) ++first;
    if (first == 4 || link.v[first] != vertex) return blocks;
    T all = T(0);
    for (int n = 0; n < 4; ++n) {
      if (place[n] == own) all += link.w[n];
      if (place[n] == nowhere) continue;
      int same = 0;
      while (place[same] != place[n]) ++same;
      blocks.weight[same] += link.w[n];
    }
    for (T& weight : blocks.weight) weight *= all;
    return blocks;
  }
};

}  // namespace weft
