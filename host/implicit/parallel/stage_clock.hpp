#pragma once

#include <chrono>
#include <utility>

#include "host/implicit/parallel/exchange.hpp"

namespace weft {

/// Measures when the stages of a step end: by time stamps in the queue of rank 0, or by the host's
/// clock if the host waits for the stage. Results do not depend on it.
class StageClock {
 public:
  /// In the order in which an attempt reaches them. Assembly is part of the solve.
  enum Mark {
    begin,
    predicted,
    contacts,
    solved,
    resolved,
    assembly_begin,
    assembled,
    marks,
  };

  explicit StageClock(DeviceSet& devices) : devices_(&devices) {}

  /// Whether every mark and every lap waits for all ranks first. The time between two of them is
  /// then that of the slowest rank, including the wait.
  void wait_for_all(bool wait) { waits_ = wait; }

  /// Records that rank 0 has reached `m`.
  void mark(Mark m) {
    if (!waits_) return (*devices_)[0].compute().stamp(&seconds_[m]);
    // No stamp: rank 0 may take it late, when other ranks already work on the next stage.
    sync_ranks(*devices_);
    seconds_[m] = now();
  }
  /// [s] between two marks.
  /// @pre the caller has waited for rank 0
  double between(Mark from, Mark to) const { return seconds_[to] - seconds_[from]; }

  void begin_laps() { lap_ = now(); }
  /// Adds the time since the previous lap. [s]
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
