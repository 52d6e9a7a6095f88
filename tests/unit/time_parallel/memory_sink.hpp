#pragma once

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <optional>

#include "host/time_parallel/slice_run.hpp"

namespace weft::test {

/// Keeps what slices give in memory.
class MemorySink : public SliceSink {
 public:
  void begin(int, std::int64_t, const Energy&) override {}
  void step(int, const StepReport& report, const std::optional<Energy>&, double) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++steps_taken;
    tracking_error = std::max(tracking_error, report.tracking_error);
  }
  void frame(int, const Scene&, const Frame& frame) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    frames[frame.number] = frame;
  }
  void sync(int) override {}

  std::map<int, Frame> frames;
  std::atomic<int> steps_taken{0};
  double tracking_error = 0;

 private:
  std::mutex mutex_;
};

}  // namespace weft::test
