#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

#include "weft/report.hpp"
#include "weft/step_progress.hpp"

namespace weft::app {

/// Hours, minutes and seconds, such as 1:02:03 or 2:03.
std::string duration_text(double seconds);

/// "[###   ]": `done` of `all`.
std::string progress_bar(std::size_t done, std::size_t all);

/// Writes a line over the one that stands on a terminal, and stays on it.
void draw_over(std::FILE* terminal, std::string line);

/// Shows how far a run is: a bar that is drawn over itself on a terminal, otherwise a line per
/// frame.
class Progress {
 public:
  /// @param out             where to write; whether it is a terminal decides the form
  /// @param frames          that the run is to have at its end
  /// @param frame_rate      [1/s]
  /// @param steps_per_frame steps that a frame takes; 0: steps are of automatic length
  Progress(std::FILE* out, int frames, double frame_rate, int steps_per_frame);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { end(); }

  /// After each step.
  /// @param frame  frames completed
  /// @param frame_ends whether this step has completed one
  /// @param number steps done since the start of the run
  /// @param wall   [s] that the step took, with what was written before it
  void step(const StepReport& report, int frame, bool frame_ends, std::int64_t number, double wall);

  /// During a step, any number of times. Shows a step of more than a second: a line in place of the
  /// bar on a terminal, otherwise a line after 1 s, 10 s, 60 s and then every minute.
  void during_step(const StepProgress& step);

  /// Leaves the line of the bar, so that other text may follow.
  void end();

 private:
  using Clock = std::chrono::steady_clock;

  void draw_bar(const StepReport& report, int frame, std::int64_t number);
  double left(const StepReport& report, std::int64_t number) const;
  std::string figures(const StepReport& report, std::int64_t number) const;

  std::FILE* out_;
  bool terminal_;
  bool drawn_ = false;
  int frames_;
  double frame_rate_;
  int steps_per_frame_;
  double mean_ = 0;              ///< [s] a step, recent ones counting most
  double mean_length_ = 0;       ///< [s] simulated in such a step
  int shown_ = -1;               ///< last frame that has a line
  std::int64_t step_shown_ = 0;  ///< latest step that has a line
  double next_line_ = 0;         ///< [s] of that step after which it gets another one
  Clock::time_point last_drawn_{};
};

/// The same for a list of frames without steps.
class FrameProgress {
 public:
  /// @param out    where to write
  /// @param frames how many there are to do
  FrameProgress(std::FILE* out, std::size_t frames);
  FrameProgress(const FrameProgress&) = delete;
  FrameProgress& operator=(const FrameProgress&) = delete;
  ~FrameProgress() { end(); }

  /// After each frame.
  /// @param done  how many are done
  /// @param label what the last one was called
  void frame(std::size_t done, const std::string& label);

  /// Leaves the line of the bar, so that other text may follow.
  void end();

 private:
  using Clock = std::chrono::steady_clock;

  std::FILE* out_;
  bool terminal_;
  bool drawn_ = false;
  std::size_t frames_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace weft::app
