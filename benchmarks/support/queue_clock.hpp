#pragma once

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

}  // namespace weft::bench
