#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "weft/report.hpp"

namespace weft {

struct AdvanceOptions {
  /// A request to stop ends the step that is under way: the state is then that of its start.
  std::stop_token stop{};
  /// Time after which no further step begins. Empty: none. It decides only how many calls a frame
  /// takes, never a result.
  std::optional<std::chrono::nanoseconds> budget{};
  /// Called with the report of each step of the call, also of one that fails. It must not call the
  /// simulation. If it throws, the step stands, and another call goes on from there.
  std::function<void(const StepReport&)> after_step{};
};

/// How far Simulation::advance() has come.
struct AdvanceResult {
  bool complete = false;  ///< the frame has ended; false: call again to go on with it
  int steps = 0;          ///< taken by this call
  Failure failure = Failure::none;
  std::string detail;  ///< one line, empty without failure

  /// Whether nothing has failed, and nobody has asked for a stop.
  explicit operator bool() const noexcept { return failure == Failure::none; }
  /// What has failed, on one line; empty: nothing.
  std::string message() const;
};

}  // namespace weft
