#include "host/app/chart/chart_progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "host/app/run/progress.hpp"
#include "host/input/safe_text.hpp"

namespace weft::app {

ChartProgress::ChartProgress(std::FILE* out, std::string title, std::size_t count)
    : out_(out), title_(one_line(title)), count_(count), terminal_(::isatty(::fileno(out)) != 0) {}

/// Before the first run has ended, nothing is known.
std::string ChartProgress::left() const {
  if (measured_ == 0) return "";
  const double spent = std::chrono::duration<double>(Clock::now() - start_).count();
  return fmt::format("  {} left", duration_text(spent / static_cast<double>(measured_) *
                                                static_cast<double>(count_ - ended_)));
}

void ChartProgress::begin(const std::string& run) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++begun_;
  if (terminal_)
    draw_over(out_, fmt::format("{} {}/{}{}  {}  {}", progress_bar(ended_, count_), begun_, count_,
                                left(), title_, one_line(run)));
  else
    fmt::print(out_, "{} {}/{} begins{}  {}\n", title_, begun_, count_, left(), one_line(run));
  std::fflush(out_);
}

void ChartProgress::end(const std::string& run, const std::string& outcome) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++ended_;
  ++measured_;
  if (terminal_) draw_over(out_, "");
  fmt::print(out_, "{} {}/{} ends{}  {}: {}\n", title_, ended_, count_, left(), one_line(run),
             one_line(outcome));
  std::fflush(out_);
}

void ChartProgress::skip() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++begun_;
  ++ended_;
}

}  // namespace weft::app
