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
    bool adds = false;
    for (int n = 3; n >= 0; --n)
      if (place[n] == own && link.w[n] != T(0)) adds = link.v[n] == vertex;
    if (!adds) return blocks;
    T all = T(0);
    for (int n = 0; n < 4; ++n) {
      if (place[n] == own) all += link.w[n];
      // To the first corner with the same place.
      bool added = place[n] == nowhere;
      for (int first = 0; first <= n; ++first)
        if (!added && place[first] == place[n]) {
          blocks.weight[first] += link.w[n];
          added = true;
        }
    }
    for (T& weight : blocks.weight) weight *= all;
    return blocks;
  }
};

}  // namespace weft
