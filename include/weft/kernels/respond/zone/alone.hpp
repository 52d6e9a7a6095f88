#pragma once

#include <algorithm>
#include <atomic>

#include "weft/core/ids.hpp"

namespace weft {

/// A team of one (see team.hpp), on the host, which may be told to stop.
struct Alone {
  const std::atomic<bool>* stop = nullptr;  ///< null: never

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }

  static constexpr bool alone = true;
  static constexpr bool in_order = true;
  static constexpr bool at_once = false;
  static constexpr Index lanes = 1;
  static constexpr Index rank() { return 0; }
  static constexpr Index size() { return 1; }
  static void sync() {}
  static double sum(double value) { return value; }
  static double largest(double value) { return value; }
  static bool any(bool value) { return value; }
  static Index before(Index value, Index& total) {
    total = value;
    return 0;
  }
  static void sort(Offset* keys, Index count) { std::sort(keys, keys + count); }
};

}  // namespace weft
