#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>

#include "weft/step_progress.hpp"

namespace weft {

/// Where a step publishes its progress, for whoever looks from another thread. The step never reads
/// it, so results do not depend on it. One thread writes, any number of threads read.
class ProgressBoard {
 public:
  /// A step begins.
  /// @param number of the step, from 1
  void begin(std::int64_t number) {
    number_ = 0;  // nobody is to see the new number with the figures of the step before
    begin_ = Clock::now().time_since_epoch().count();
    const StepProgress start;
    enter(StepStage::prediction, start.fallback_level);
    set_substep(start.substep, start.done);
    set_solves(start.solves);
    set_round(start.zone_rounds, start.zones, start.impacts);
    zone_work_left_ = start.zone_work_left;
    set_truncated_solves(start.truncated_solves, start.truncated_solves_left);
    number_ = number;
  }
  void end() { number_ = 0; }

  void enter(StepStage stage) { stage_ = stage; }
  void enter(StepStage stage, FallbackLevel level) {
    stage_ = stage;
    level_ = level;
  }
  void set_substep(double length, double done) {
    substep_ = length;
    done_ = done;
  }
  void set_solves(int solves) { solves_ = solves; }
  void set_round(int rounds, int zones, std::int64_t impacts) {
    zone_rounds_ = rounds;
    zones_ = zones;
    impacts_ = impacts;
  }
  /// @param left, granted visits of impacts
  void set_zone_work(std::int64_t left, std::int64_t granted) {
    const double share =
        static_cast<double>(left) / static_cast<double>(std::max<std::int64_t>(1, granted));
    zone_work_left_ = std::clamp(share, 0.0, 1.0);
  }
  void set_truncated_solves(int done, int left) { truncated_solves_ = TruncatedSolves{done, left}; }

  /// What the step has published. All values are of one step; if it ends meanwhile, there is none.
  StepProgress read() const {
    StepProgress p;
    p.number = number_;
    if (p.number == 0) return {};
    const Clock::duration spent = Clock::now().time_since_epoch() - Clock::duration(begin_.load());
    p.seconds = std::max(0.0, std::chrono::duration<double>(spent).count());
    p.stage = stage_;
    p.fallback_level = level_;
    p.substep = substep_;
    p.done = done_;
    p.solves = solves_;
    p.zone_rounds = zone_rounds_;
    p.zones = zones_;
    p.impacts = impacts_;
    p.zone_work_left = zone_work_left_;
    const TruncatedSolves truncated = truncated_solves_;
    p.truncated_solves = truncated.done;
    p.truncated_solves_left = truncated.left;
    return number_ == p.number ? p : StepProgress{};
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// Published as one value: readers add the two.
  struct TruncatedSolves {
    int done = 0, left = 0;
  };

  std::atomic<std::int64_t> number_{0};
  std::atomic<Clock::rep> begin_{0};
  std::atomic<StepStage> stage_{StepStage::none};
  std::atomic<FallbackLevel> level_{FallbackLevel::whole};
  std::atomic<double> substep_{1}, done_{0};
  std::atomic<int> solves_{0}, zone_rounds_{0}, zones_{0};
  std::atomic<std::int64_t> impacts_{0};
  std::atomic<double> zone_work_left_{1};
  std::atomic<TruncatedSolves> truncated_solves_{TruncatedSolves{}};
  static_assert(std::atomic<TruncatedSolves>::is_always_lock_free);
};

}  // namespace weft
