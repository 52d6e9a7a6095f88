#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "host/app/run/progress.hpp"
#include "weft/step_progress.hpp"

namespace weft::app {

/// Shows from a thread of its own how far a long step is.
class Heartbeat {
 public:
  /// @param progress shows the step. Nobody else may use it while a Watch lives
  /// @param ask      how far the step is; called from the other thread, while a Watch lives
  /// @param interval between two looks
  Heartbeat(Progress& progress, std::function<StepProgress()> ask,
            std::chrono::milliseconds interval = std::chrono::milliseconds(250));
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// While it lives, a step is under way.
  class Watch {
   public:
    explicit Watch(Heartbeat& heartbeat) : heartbeat_(heartbeat) { heartbeat_.set_on(true); }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    ~Watch() { heartbeat_.set_on(false); }

   private:
    Heartbeat& heartbeat_;
  };

 private:
  void set_on(bool on);
  void look(const std::stop_token& stop);

  Progress& progress_;
  std::function<StepProgress()> ask_;
  std::chrono::milliseconds interval_;
  std::mutex mutex_;  ///< of on_, and of progress_ while it is true
  std::condition_variable_any ended_;
  bool on_ = false;
  std::jthread thread_;  ///< last: it uses all of the above
};

}  // namespace weft::app
