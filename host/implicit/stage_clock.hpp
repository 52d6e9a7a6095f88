#pragma once

#include <chrono>
#include <utility>

#include "host/implicit/parallel/exchange.hpp"

namespace weft {

/// When stages of a step end: by stamps in the work of rank 0, or by the host's clock where the
/// host has waited for what it measures. Nothing that is simulated depends on it.
class StageClock {
 public:
  /// In the order of an attempt; assembly is within the solve.
  enum Mark {
    begin,
    predicted,
    contacts,
    solved,
    certified,
    assembly_begin,
    assembled,
    marks,
  };

  explicit StageClock(DeviceSet& devices) : devices_(&devices) {}

  /// Whether every mark and every lap waits for all ranks first. What is between two of them is
  /// then the time of the slowest rank, and of that waiting.
  void wait_for_all(bool wait) { waits_ = wait; }

  /// Rank 0 has come so far.
  void mark(Mark m) {
    if (!waits_) return (*devices_)[0].compute().stamp(&seconds_[m]);
    // Not by a stamp: until rank 0 gets round to it, other ranks may be at work on what comes next.
    sync_ranks(*devices_);
    seconds_[m] = now();
  }
  /// [s] between two marks. Rank 0 has been waited for.
  double between(Mark from, Mark to) const { return seconds_[to] - seconds_[from]; }

  void begin_laps() { lap_ = now(); }
  /// Adds the time since the lap before. [s]
  void lap(double& seconds) {
    if (waits_) sync_ranks(*devices_);
    const double before = std::exchange(lap_, now());
    seconds += lap_ - before;
  }

 private:
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }

  DeviceSet* devices_;
  double seconds_[marks] = {};
  double lap_ = 0;
  bool waits_ = false;
};

}  // namespace weft
