#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// How a component of cloth, all that its triangles and ties connect, has moved of late. Windows
/// are runs of steps, counted from the start of the run.
struct SleepComponent {
  /// [m] How far a vertex has been from its mark of this window, at most; infinite if the piece
  /// slept then.
  double excursion = std::numeric_limits<double>::infinity();
  double before = std::numeric_limits<double>::infinity();  ///< [m] likewise, in the window before
  double jitter = 0;        ///< [m] by which it is taken to go to and fro while it sleeps
  double drift = 0;         ///< [m] a window, that it is taken to move on by
  double bend = 0;          ///< [m] a window squared, by which that is taken to grow
  double spent = 0;         ///< [m] departure from a run without sleep, of earlier sleeps
  std::int64_t since = -1;  ///< number of the step before its sleep; -1: it is awake
};

/// What sleepers were lulled by. Another one, in a run that is resumed, wakes them.
struct SleepCauses {
  Vec3<double> gravity{}, wind{};  ///< [m/s^2] [m/s]
  double air = 0, drag = 0;        ///< as in Wind
  double thickness = 0;            ///< [m] of contacts
  std::int64_t window = 0;         ///< steps
  friend bool operator==(const SleepCauses& a, const SleepCauses& b) {
    for (int c = 0; c < 3; ++c)
      if (a.gravity[c] != b.gravity[c] || a.wind[c] != b.wind[c]) return false;
    return a.air == b.air && a.drag == b.drag && a.thickness == b.thickness && a.window == b.window;
  }
};

/// Part of the state, see SleepingStep; empty where nothing may sleep.
template <class T>
struct SleepState {
  std::vector<SleepComponent> pieces;
  /// [2][cloth vertices] [m] Marks: where vertices were when this window began, and when the one
  /// before did, each the mean of two steps, between which contacts may go to and fro.
  std::vector<Vec3<T>> marks[2];
  SleepCauses causes;
};

}  // namespace weft
