#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "weft/report.hpp"

namespace weft::app {

/// One line of steps.jsonl.
struct StepLine {
  StepReport report;
  double wall = 0;               ///< [s] since the line before, or since the program started
  std::optional<Energy> energy;  ///< after the last step of a frame
};

/// steps.jsonl while a run writes it: lines are collected, then appended together.
class StepLog {
 public:
  /// Replaces `file` by `kept`.
  /// @throws SceneError naming the file if it cannot be written
  StepLog(const std::filesystem::path& file, const std::string& kept);
  StepLog(const StepLog&) = delete;
  StepLog& operator=(const StepLog&) = delete;
  ~StepLog();

  void add(const StepLine& line);

  /// Appends what was collected, so that it outlives this process.
  /// @throws SceneError if it cannot be written
  void flush();

  /// Waits until the disk has what was flushed. Another thread may add lines meanwhile.
  void sync() const;

 private:
  std::string file_;
  int descriptor_ = -1;
  std::string pending_;
};

/// Reads the lines of steps 1 to `last_step`, passes them to `take` and returns them as text.
/// A line that a kill cut off, or that repeats a step, is left out.
std::string read_steps(const std::filesystem::path& file, std::int64_t last_step,
                       const std::function<void(const StepLine&)>& take);

}  // namespace weft::app
