#pragma once

#include <cmath>
#include <cstdint>
#include <queue>
#include <vector>

namespace weft {

/// When a bucket of forces acts: at integer multiples of its step, counted from t = 0. So neither
/// where a window begins nor when a bucket was made changes the times, to the bit.
struct Ticks {
  double step;  ///< [s]

  double time(std::int64_t k) const { return static_cast<double>(k) * step; }
  /// Number of the first tick that is not before `t` >= 0.
  std::int64_t first_from(double t) const {
    auto k = static_cast<std::int64_t>(t / step);
    while (k > 0 && time(k - 1) >= t) --k;
    while (time(k) < t) ++k;
    return k;
  }
};

/// The next tick of a bucket.
struct Tick {
  double time;  ///< [s]
  int bucket;
  std::int64_t number;

  bool operator>(const Tick& b) const { return time != b.time ? time > b.time : bucket > b.bucket; }
};

/// Earliest tick first; at one time buckets in the order of their numbers.
using TickQueue = std::priority_queue<Tick, std::vector<Tick>, std::greater<>>;

}  // namespace weft
