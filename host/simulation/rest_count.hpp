#pragma once

#include <cstdint>
#include <vector>

#include "host/state/quiet_frames.hpp"
#include "weft/core/span.hpp"
#include "weft/rest_state.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Counts quiet frames, see RestState.
class RestCount {
 public:
  /// @param last_change [s] of the scene, see last_change()
  void reset(double last_change) {
    last_change_ = last_change;
    state_ = {};
  }

  /// At the end of a frame. It is not quiet unless the positions of the frame before are known.
  /// @param positions  [vertices of cloth] [m]
  /// @param velocities [vertices of cloth] [m/s]
  /// @param end        [s]
  /// @param frames     quiet frames that make rest
  template <class T>
  void add_frame(Span<const Vec3<T>> positions, Span<const Vec3<T>> velocities, double end,
                 int frames);

  /// Where cloth is at the beginning of a frame, if it was not told by add_frame().
  /// @param positions [vertices of cloth] [m]   @param time [s]
  template <class T>
  void begin_frame(Span<const Vec3<T>> positions, double time);

  const RestState& state() const { return state_; }

  /// What a checkpoint holds.
  QuietFrames quiet_frames() const;
  /// Goes on with that.
  void restore(QuietFrames quiet, int frames);

 private:
  template <class T>
  bool is_quiet(Span<const Vec3<T>> positions, Span<const Vec3<T>> velocities, double duration,
                int frames);

  double last_change_ = 0;
  RestState state_;
  std::vector<Vec3<double>> since_;   ///< [m] before the first of the quiet frames
  std::vector<Vec3<double>> before_;  ///< [m] at the end of the last frame
  double before_time_ = 0;            ///< [s]
};

/// Quiet frames that make rest: those of quiet_duration, and at least two.
int quiet_frames_of_rest(const TimeSettings& time);

/// [s] The last change that a scene has planned, see RestState; infinite with a clip that repeats.
double last_change(const Scene& scene);

}  // namespace weft
