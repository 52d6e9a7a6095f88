#include "host/app/run/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "host/app/process/show.hpp"

namespace weft::app {
namespace {

constexpr auto redraw_interval = std::chrono::milliseconds(100);
constexpr std::size_t bar_cells = 24;
/// [s] A step that takes longer is shown while it is under way.
constexpr double long_step = 1;

/// [s] of a step after which a log gets its next line about it, if it got one at `seconds`. Logs
/// stay short, however long the step is.
double next_line_after(double seconds) {
  if (seconds < 10) return 10;
  return 60 * (std::floor(seconds / 60) + 1);
}

std::size_t columns(std::FILE* out) {
  winsize size{};
  if (::ioctl(::fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col < 2) return 80;
  return size.ws_col;
}

}  // namespace

std::string duration_text(double seconds) {
  const auto s = static_cast<std::int64_t>(std::ceil(seconds));
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string progress_bar(std::size_t done, std::size_t all) {
  const std::size_t filled = std::min(done, all) * bar_cells / std::max<std::size_t>(1, all);
  return fmt::format("[{:<{}}]", std::string(filled, '#'), bar_cells);
}

void draw_over(std::FILE* terminal, std::string line) {
  // A line that wraps could not be drawn over.
  line.resize(std::min(line.size(), columns(terminal) - 1));
  show(terminal, "\r{}\x1b[K", line);
}

Progress::Progress(std::FILE* out, int frames, double frame_rate, int steps_per_frame)
    : out_(out),
      terminal_(::isatty(::fileno(out)) != 0),
      frames_(frames),
      frame_rate_(frame_rate),
      steps_per_frame_(steps_per_frame) {}

/// [s] wall time until the end of the run
double Progress::left(const StepReport& report, std::int64_t number) const {
  const std::int64_t all = std::int64_t{frames_} * steps_per_frame_;
  if (all > 0) return mean_ * static_cast<double>(std::max<std::int64_t>(0, all - number));
  const double simulated = std::max(0.0, frames_ / frame_rate_ - report.time);
  return mean_length_ > 0 ? mean_ / mean_length_ * simulated : 0;
}

std::string Progress::figures(const StepReport& report, std::int64_t number) const {
  const std::string length =
      steps_per_frame_ > 0 ? "" : fmt::format("  steps of {:.3g} s", mean_length_);
  return fmt::format("{:.3g} ms/step{}  {} contacts  {} left", mean_ * 1e3, length,
                     report.proximities, duration_text(left(report, number)));
}

void Progress::step(const StepReport& report, int frame, bool frame_ends, std::int64_t number,
                    double wall) {
  // A mean over about the last frame, so that the frame's writing is spread over its steps.
  const double weight = 1.0 / std::max(4, steps_per_frame_);
  mean_ = mean_ > 0 ? mean_ + weight * (wall - mean_) : wall;
  mean_length_ =
      mean_length_ > 0 ? mean_length_ + weight * (report.step - mean_length_) : report.step;
  if (terminal_) {
    draw_bar(report, frame, number);
  } else if (frame_ends && frame != shown_) {
    shown_ = frame;
    show(out_, "frame {}/{}  {:.4g} s  {}\n", frame, frames_, report.time, figures(report, number));
  }
}

void Progress::during_step(const StepProgress& step) {
  if (step.number == 0 || step.seconds < long_step) return;
  if (terminal_) {
    drawn_ = true;
    return draw_over(out_, describe(step));
  }
  if (step.number != step_shown_) next_line_ = long_step;
  step_shown_ = step.number;
  if (step.seconds < next_line_) return;
  next_line_ = next_line_after(step.seconds);
  show(out_, "{}\n", describe(step));
}

void Progress::draw_bar(const StepReport& report, int frame, std::int64_t number) {
  const auto now = Clock::now();
  if (drawn_ && now - last_drawn_ < redraw_interval && frame < frames_) return;
  last_drawn_ = now;
  drawn_ = true;
  // In thousandths of a frame.
  const auto done = static_cast<std::size_t>(std::max(0.0, 1e3 * report.time * frame_rate_));
  const std::size_t all = std::size_t{1000} * static_cast<std::size_t>(frames_);
  draw_over(out_, fmt::format("{} frame {}/{}  {}", progress_bar(done, all), frame, frames_,
                              figures(report, number)));
}

void Progress::end() {
  if (drawn_) show(out_, "\n");
  drawn_ = false;
}

FrameProgress::FrameProgress(std::FILE* out, std::size_t frames)
    : out_(out), terminal_(::isatty(::fileno(out)) != 0), frames_(frames) {}

void FrameProgress::frame(std::size_t done, const std::string& label) {
  const std::chrono::duration<double> spent = Clock::now() - start_;
  const double each = spent.count() / static_cast<double>(std::max<std::size_t>(1, done));
  const std::string figures =
      fmt::format("{:.3g} s/frame  {} left", each,
                  duration_text(each * static_cast<double>(frames_ - std::min(done, frames_))));
  if (terminal_) {
    draw_over(out_, fmt::format("{} frame {}/{}  {}", progress_bar(done, frames_), done, frames_,
                                figures));
    drawn_ = true;
  } else {
    show(out_, "{}  {}/{}  {}\n", label, done, frames_, figures);
  }
}

void FrameProgress::end() {
  if (drawn_) show(out_, "\n");
  drawn_ = false;
}

}  // namespace weft::app
