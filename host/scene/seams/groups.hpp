#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "weft/core/at.hpp"
#include "weft/core/ids.hpp"

namespace weft {

/// Items that are joined two by two into groups.
class Groups {
 public:
  explicit Groups(std::size_t count) : lowest_(count) {
    std::iota(lowest_.begin(), lowest_.end(), 0);
  }

  /// @pre both are below the count
  void join(Index a, Index b) {
    a = root(a);
    b = root(b);
    lowest_[at(std::max(a, b))] = std::min(a, b);
  }

  /// Of each item the lowest one of its group. It holds until the next is joined.
  const std::vector<Index>& lowest() {
    for (std::size_t i = 0; i < lowest_.size(); ++i) lowest_[i] = root(static_cast<Index>(i));
    return lowest_;
  }

 private:
  Index root(Index i) {
    while (lowest_[at(i)] != i) i = lowest_[at(i)] = lowest_[at(lowest_[at(i)])];
    return i;
  }

  std::vector<Index> lowest_;  ///< some lower item of the group, or itself
};

}  // namespace weft
