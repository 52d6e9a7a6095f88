#pragma once

#include <cstddef>
#include <vector>

#include "weft/core/ids.hpp"

namespace weft {

/// Items by a key: those of one key are neighbours, in their order.
struct Buckets {
  std::vector<Index> offset;  ///< [keys + 1] into `item`
  std::vector<Index> item;

  Index* begin(Index key) { return item.data() + offset[static_cast<std::size_t>(key)]; }
  Index* end(Index key) { return item.data() + offset[static_cast<std::size_t>(key) + 1]; }
  const Index* begin(Index key) const {
    return item.data() + offset[static_cast<std::size_t>(key)];
  }
  const Index* end(Index key) const {
    return item.data() + offset[static_cast<std::size_t>(key) + 1];
  }
};

/// @param key key(i) of item i < item_count: below key_count; negative: it is left out
template <class Key>
Buckets buckets_by(Index item_count, Index key_count, const Key& key) {
  Buckets b;
  b.offset.assign(static_cast<std::size_t>(key_count) + 1, 0);
  for (Index i = 0; i < item_count; ++i)
    if (const Index k = key(i); k >= 0) ++b.offset[static_cast<std::size_t>(k) + 1];
  for (std::size_t k = 0; k + 1 < b.offset.size(); ++k) b.offset[k + 1] += b.offset[k];
  b.item.resize(static_cast<std::size_t>(b.offset.back()));
  std::vector<Index> next(b.offset.begin(), b.offset.end() - 1);
  for (Index i = 0; i < item_count; ++i)
    if (const Index k = key(i); k >= 0)
      b.item[static_cast<std::size_t>(next[static_cast<std::size_t>(k)]++)] = i;
  return b;
}

}  // namespace weft
