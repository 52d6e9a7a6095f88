#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <mutex>
#include <string>

namespace weft::app {

/// Shows how far a list of runs is: a line as each begins and as it ends, with their count and the
/// time left. On a terminal, a bar that is drawn over itself takes the place of lines that begin.
/// Safe to use from several threads.
class ChartProgress {
 public:
  /// @param out   where to write; whether it is a terminal decides the form
  /// @param title of the list
  /// @param count of its runs
  ChartProgress(std::FILE* out, std::string title, std::size_t count);
  ChartProgress(const ChartProgress&) = delete;
  ChartProgress& operator=(const ChartProgress&) = delete;

  void begin(const std::string& run);
  /// @param outcome one line
  void end(const std::string& run, const std::string& outcome);
  /// Of a run that an earlier sweep has done.
  void skip();

 private:
  using Clock = std::chrono::steady_clock;

  std::string left() const;

  std::FILE* out_;
  std::string title_;
  std::size_t count_;
  std::size_t begun_ = 0, ended_ = 0, measured_ = 0;
  bool terminal_;
  Clock::time_point start_ = Clock::now();
  std::mutex mutex_;
};

}  // namespace weft::app
