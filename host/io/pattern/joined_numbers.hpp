#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace weft::io {

/// Numbers of which some have become one.
class JoinedNumbers {
 public:
  explicit JoinedNumbers(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  /// The lowest of those that a number is one with.
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({find(a), find(b)});
    parent_[high] = low;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace weft::io
