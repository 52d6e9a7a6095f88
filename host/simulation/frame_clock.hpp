#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/base/bytes.hpp"
#include "host/simulation/step_control.hpp"
#include "weft/scene.hpp"

namespace weft {

/// When the steps and frames of a simulation begin and end: those of its scene, or those of
/// Simulation::advance(), whose length the program chooses.
class FrameClock {
 public:
  /// A step that is not automatic.
  struct FixedStep {
    double length;  ///< [s]
    double end;     ///< [s] time
  };

  FrameClock() = default;
  /// @param scene valid
  explicit FrameClock(const Scene& scene);

  bool automatic() const { return time_.automatic; }
  /// 0 if steps are automatic
  int steps_per_frame() const { return steps_per_frame_; }
  /// @pre automatic()
  const StepControl& step_control() const { return *control_; }
  /// [s] of the next step of the scene's length
  /// @param now  [s]   @param next [s] that an automatic step may have
  double step_length(double now, double next) const;
  /// The step of this number. Its end is counted, not summed up, so that a resumed run sees the
  /// same times.
  /// @param now [s]   @pre not automatic()
  FixedStep next_fixed(std::int64_t number, double now) const;

  /// [s] The latest time at which the step of this number may end.
  /// @param now [s]   @param next [s] that an automatic step may have
  double latest_end(std::int64_t number, double now, double next) const;

  /// Whether a time is that of so many of the scene's steps, and not what frames of the program's
  /// own lengths have made of it.
  bool counts(double now, std::int64_t steps) const;
  bool at_frame_end(double now, std::int64_t steps) const;
  /// Frames of the scene that are completed.
  int frame_number(double now, std::int64_t steps) const;

  /// Whether a frame of the program's has begun and not ended.
  bool in_program_frame() const { return frame_.has_value(); }
  /// Begins a frame of the program's.
  /// @param now [s]   @param steps so far
  /// @return [s] time of its end
  /// @throws SceneError if it has no step, more than a million, or is no whole number of frames
  ///         whose steps are automatic
  double begin_program_frame(double seconds, double now, std::int64_t steps);
  /// @pre in_program_frame()
  bool program_frame_ended(double now, std::int64_t steps) const;
  void end_program_frame() { frame_.reset(); }

  /// What renumbered() says of a checkpoint's state.
  struct Counted {
    double time;         ///< [s]
    std::int64_t steps;  ///< so far
  };
  /// Numbers the steps of a checkpoint as this scene does, whose steps may be of another length.
  /// @param now [s]   @param file for messages
  /// @throws SceneError if its time is not at the end of one of them
  Counted renumbered(double now, std::int64_t steps, const std::string& file) const;

  /// The program's frame, for a checkpoint.
  void pack(Packer& packer, bool counted) const;
  /// Reads what pack() has written.
  /// @return counted
  /// @throws SceneError if it makes no sense
  bool unpack(Unpacker& unpacker);
  /// Bytes that pack() writes.
  static constexpr std::size_t packed_size() { return sizeof(ProgramFrame) + 2; }

 private:
  struct ProgramFrame {
    double start = 0, end = 0;                  ///< [s]
    std::int64_t start_step = 0, end_step = 0;  ///< unless steps are automatic
    double length = 0;                          ///< [s] of its steps; 0: of the scene's
  };
  /// Whether a frame is under way whose steps are not the scene's.
  bool has_own_steps() const { return frame_ && frame_->length > 0; }

  TimeSettings time_;
  std::string file_;                    ///< of the scene
  std::optional<StepControl> control_;  ///< none: steps are not automatic
  int steps_per_frame_ = 0;
  std::optional<ProgramFrame> frame_;
};

}  // namespace weft
