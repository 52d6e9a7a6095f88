#pragma once

#include <algorithm>
#include <vector>

#include "benchmarks/support/delay.hpp"
#include "weft/exec/device.hpp"

namespace weft::bench {

/// Takes the time of work of a queue, by the queue's own clock: on CUDA between events.
class QueueClock {
 public:
  void start(Queue& queue) {
#if defined(WEFT_CUDA)
    // The device would else wait for the host between the event and the kernel's parts.
    if (queue.backend() == Backend::cuda) delay(queue, 150);
#endif
    queue.stamp(&begin_);
  }
  /// Waits for the queue.
  /// @return [s] that the work since start() took
  double stop(Queue& queue) {
    queue.stamp(&end_);
    queue.sync();
    return end_ - begin_;
  }

 private:
  double begin_ = 0, end_ = 0;
};

/// Median time of what a call submits [s], of `repeats` after a first one that does not count.
template <class Submit>
double median_time(Queue& queue, int repeats, const Submit& submit) {
  QueueClock clock;
  std::vector<double> times;
  for (int repeat = 0; repeat <= repeats; ++repeat) {
    clock.start(queue);
    submit();
    const double seconds = clock.stop(queue);
    if (repeat > 0) times.push_back(seconds);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

}  // namespace weft::bench
