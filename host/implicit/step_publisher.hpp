#pragma once

#include "host/state/progress_board.hpp"
#include "weft/report.hpp"

namespace weft {

/// Publishes the progress of a step. Results do not depend on it. Until publish_on() is called, the
/// progress goes to a board that is not read.
class StepPublisher {
 public:
  /// @param board must outlive the steps; its owner begins and ends each step on it
  void publish_on(ProgressBoard& board) { board_ = &board; }
  ProgressBoard& board() const { return *board_; }
  ProgressBoard* operator->() const { return board_; }

  /// Whether the step has fallen back to truncation.
  void set_truncating(bool truncating) { truncating_ = truncating; }
  /// A stage begins.
  void enter(StepStage stage, const StepReport& report) const {
    board_->enter(stage, truncating_ ? FallbackLevel::truncated : report.fallback_level);
  }

 private:
  ProgressBoard own_;
  ProgressBoard* board_ = &own_;
  bool truncating_ = false;
};

}  // namespace weft
