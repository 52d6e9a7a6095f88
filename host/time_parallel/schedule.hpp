#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace weft {

// How the steps of a run are shared out among workers that each simulate a slice of time, after a
// coarse run that is `ratio` times as fast a step (Liang & Lin 2018, section 4). Paper letters: N
// steps, p slices, K ratio, s_j starts.

/// First steps of slices of one length, eq. (3).
/// @pre 1 <= slices <= steps
std::vector<std::int64_t> uniform_starts(std::int64_t steps, int slices);

/// First steps of slices that all end at one time if each begins as soon as the coarse run is
/// there, eq. (5). Each slice has at least one step, which the formula does not see to.
/// @param ratio > 1, infinity: as uniform_starts()
/// @pre 1 <= slices <= steps
std::vector<std::int64_t> balanced_starts(std::int64_t steps, int slices, double ratio);

/// Speed-up of slices of one length over the serial run, eq. (4).
double uniform_speedup(double ratio, int slices);

/// Speed-up of balanced slices, eq. (6); no slices of these costs do better.
double balanced_speedup(double ratio, int slices);

/// What is below any of them: all of the coarse run first, eq. (11).
double least_speedup(double ratio, int slices);

/// Speed-up where each slice begins with steps that recover detail, eq. (16).
/// @param steps      N
/// @param recovery   steps of one recovery
/// @param speedup    without it, such as balanced_speedup()
double speedup_with_recovery(std::int64_t steps, double recovery, double speedup);

/// Where the slice that is under way has to end, of the steps that are left, eq. (9).
/// @param steps  left, from the slice's first one on
/// @param slices left, this one included, >= 1
/// @param ratio  counted so far, >= 1; infinity: nothing is known
/// @return       steps of the slice, not rounded
double adaptive_cut(std::int64_t steps, int slices, double ratio);

/// What a slice has done by some time.
struct SliceDone {
  std::int64_t steps = 0;
  double work = 0;  ///< of these, with its recovery

  /// @param work [steps done + 1, at least 1] of the slice: after its recovery, then after each
  /// step
  /// @param most of work; steps beyond are not looked at
  static SliceDone within(const std::vector<double>& work, double most);
};

/// Algorithm 1 with counted work for time: says where slices begin while the coarse run goes on and
/// the slices behind it are under way. Its outcome depends on what was counted alone, not on who
/// was how fast: a slice's progress is what it has done once its work is that of the coarse run
/// since the slice's start.
///
/// The ratio of eq. (7) is that of the latest slices which have done known_steps together, and
/// counts as unknown, which makes for slices of one length, as long as all have done fewer. The
/// paper has it from the slice under way alone, from its first step on: where the ratio is larger
/// than a slice has steps, that is one or two, among them those of a run that has hardly begun to
/// move, and one slice that these make too long is too long for all others to make up for. For the
/// same reason no slice is longer than length_max slices of one length would be from its start on:
/// a while in which the coarse run costs as much as the fine one is not what is to come.
class AdaptiveCuts {
 public:
  /// Steps that tell a ratio of costs.
  static constexpr std::int64_t known_steps = 20;
  /// Length of a slice, at most, over that of slices of one length.
  static constexpr double length_max = 1.3;

  /// @pre 1 <= slices <= steps
  AdaptiveCuts(std::int64_t steps, int slices);

  /// First steps of the slices decided so far; the first is 0.
  const std::vector<std::int64_t>& starts() const { return starts_; }
  bool complete() const { return static_cast<int>(starts_.size()) == slices_; }

  /// Number of the slice whose end is asked for.
  int slice() const { return static_cast<int>(starts_.size()) - 1; }

  /// The coarse run has come farther.
  /// @param step  first step of the fine run that it has not reached, in increasing order
  /// @param work  counted since its start
  /// @pre the end of slice() could not be decided before
  void advance_coarse(std::int64_t step, double work);

  /// Looks at what slices have done some time ago rather than now: those who count then need not
  /// be in step. Until it is set nothing counts as done.
  /// @param work of that time, >= 0
  void set_delay(double work) { delay_ = work; }
  /// Looks at all that slices have done when decide() is asked: for costs by the clock, where that
  /// is what they have done in the coarse run's time.
  void look_at_all() { delay_ = -std::numeric_limits<double>::infinity(); }
  bool has_delay() const { return delay_ < std::numeric_limits<double>::infinity(); }

  /// Work that a slice has to have done, or be at its last known step, before decide() may be
  /// asked: what the coarse run has done since the slice's start, less the delay.
  double work_wanted(int slice) const;

  /// Decides whether slice() ends within what the coarse run has reached, and not before what it
  /// had reached at the advance before.
  /// @param done what a slice, slice() or one before, has done within work_wanted() of it
  /// @return     whether it does: starts() then has one more
  bool decide(const std::function<SliceDone(int slice, double work_wanted)>& done);

  /// Ends slice() not before a step that it has done already.
  void keep(std::int64_t step) { kept_ = step; }

  /// Ends slice() where an earlier run has ended it.
  /// @return whether the coarse run has got that far: starts() then has one more
  bool follow(std::int64_t start);

 private:
  double coarse_work(std::int64_t step) const;
  double ratio(const std::function<SliceDone(int slice, double work_wanted)>& done) const;

  std::int64_t steps_;
  int slices_;
  std::vector<std::int64_t> starts_{0};
  std::vector<std::int64_t> coarse_steps_{0};
  std::vector<double> coarse_work_{0};
  std::int64_t kept_ = 0;
  double delay_ = std::numeric_limits<double>::infinity();
};

/// What a schedule comes to when every step has a known cost.
struct ScheduleCosts {
  std::vector<double> coarse;  ///< [steps + 1] of the coarse run until it has reached each step
  std::vector<double> fine;    ///< [steps + 1] of the fine run likewise
  double recovery = 0;         ///< of each slice but the first
};

/// When the last of the slices ends, if each has a worker of its own, but the last, which is for
/// the worker of the coarse run: each begins when the coarse run has reached its start.
/// @param starts first steps of slices, increasing from 0
double schedule_length(const ScheduleCosts& costs, const std::vector<std::int64_t>& starts);

/// Algorithm 1 on known costs.
std::vector<std::int64_t> adaptive_starts(const ScheduleCosts& costs, int slices);

}  // namespace weft
