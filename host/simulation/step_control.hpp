#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Chooses the length of time steps (TimeSettings::automatic) from the error of the one before: an
/// elementary controller (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I,
/// section II.4). The remainder of a frame is divided evenly, so frames are hit exactly and no step
/// is a small rest. Depends on the state alone. Every step ends: attempts, growth and shrinkage are
/// bounded, and the shortest step is taken whatever its error is.
class StepControl {
 public:
  /// Between two steps the length grows by up to this factor: variable-step BDF2 is stable to
  /// 1 + sqrt(2) (Grigorieff 1983).
  static constexpr double growth_max = 2;
  static constexpr double shrinkage_max = 4;
  /// Attempts at one step that are taken back.
  static constexpr int rejections_max = 4;
  /// A step is taken again if its error is beyond so many tolerances. Below that it costs more than
  /// it gains: the next step is shorter anyway.
  static constexpr double rejected_error = 2;

  StepControl(const TimeSettings& time, Integrator integrator);

  struct Step {
    double length;    ///< [s]
    double end;       ///< [s] time
    bool ends_frame;  ///< `end` is that of a frame, to the bit
  };

  /// Frames that are completed at a time.
  int frames(double now) const;
  /// Whether a frame ends at a time.
  bool at_frame_end(double now) const;

  /// @param length [s] that the step may have; 0: the first step
  /// @param now    [s] time of the state
  Step next(double length, double now) const;

  /// Whether a step has to be taken again.
  /// @param error      over the tolerance
  /// @param rejections of this step so far
  bool rejects(const Step& step, double error, int rejections) const;

  /// [s] Length of another attempt at a step that has been rejected.
  double again(const Step& step, double error) const;

  /// [s] Length that the step after this one may have.
  /// @param may_grow false: something else than the error has limited the step
  double after(const Step& step, double error, bool may_grow) const;

 private:
  double shortest() const;
  double factor(double error) const;

  TimeSettings time_;
  double frame_;  ///< [s]
  double order_;  ///< of the error of a step
};

}  // namespace weft
