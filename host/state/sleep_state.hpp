#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Recent motion of a component of cloth. A window is a fixed number of steps, counted from the
/// start of the run.
struct SleepComponent {
  /// [m] Largest distance of a vertex from its mark in this window; infinite if the component slept
  /// in this window.
  double excursion = std::numeric_limits<double>::infinity();
  double before = std::numeric_limits<double>::infinity();  ///< [m] in the previous window
  double jitter = 0;        ///< [m] assumed amplitude of its oscillation during sleep
  double drift = 0;         ///< [m per window] its assumed motion during sleep
  double bend = 0;          ///< [m per window squared] assumed growth of the drift
  double spent = 0;         ///< [m] bound on the error of its earlier sleeps
  std::int64_t since = -1;  ///< number of the last step before its sleep; -1: it is awake
};

/// Conditions under which components fell asleep. A resumed run with other conditions wakes them.
struct SleepCauses {
  Vec3<double> gravity{}, wind{};  ///< [m/s^2] [m/s]
  double air = 0, drag = 0;        ///< as in Wind
  double thickness = 0;            ///< [m] of contacts
  std::int64_t window = 0;         ///< number of steps
  friend bool operator==(const SleepCauses& a, const SleepCauses& b) {
    for (int c = 0; c < 3; ++c)
      if (a.gravity[c] != b.gravity[c] || a.wind[c] != b.wind[c]) return false;
    return a.air == b.air && a.drag == b.drag && a.thickness == b.thickness && a.window == b.window;
  }
};

/// Part of the state, see SleepingStep; empty if nothing may sleep.
template <class T>
struct SleepState {
  std::vector<SleepComponent> pieces;
  /// [2][cloth vertices] [m] Marks: positions at the start of this window and of the previous one.
  /// Each is the mean of two steps, because contacts may oscillate from one step to the next.
  std::vector<Vec3<T>> marks[2];
  SleepCauses causes;
};

}  // namespace weft
