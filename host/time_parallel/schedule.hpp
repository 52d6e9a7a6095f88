#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace weft {

// Divides the steps of a run into slices of time, one per worker (Liang & Lin 2018, section 4).
// `ratio` is the cost of a step of the fine run over that of the coarse run for the same time. The
// paper writes N for steps, p for slices, K for ratio and s_j for starts.

/// First steps of slices of equal length, eq. (3).
/// @pre 1 <= slices <= steps
std::vector<std::int64_t> uniform_starts(std::int64_t steps, int slices);

/// First steps of slices that all end at the same time if each begins as soon as the coarse run
/// reaches it, eq. (5). Unlike the formula, this gives each slice at least one step.
/// @param ratio > 1, infinity: as uniform_starts()
/// @pre 1 <= slices <= steps
std::vector<std::int64_t> balanced_starts(std::int64_t steps, int slices, double ratio);

/// Speed-up of slices of equal length over the serial run, eq. (4).
double uniform_speedup(double ratio, int slices);

/// Speed-up of balanced slices, eq. (6). No other slices are faster at these costs.
double balanced_speedup(double ratio, int slices);

/// Lower bound of both, eq. (11): the slices begin after the whole coarse run.
double least_speedup(double ratio, int slices);

/// Speed-up if each slice begins with steps that recover detail, eq. (16).
/// @param steps      N
/// @param recovery   number of steps of one recovery
/// @param speedup    without recovery, such as balanced_speedup()
double speedup_with_recovery(std::int64_t steps, double recovery, double speedup);

/// Length of the current slice, eq. (9).
/// @param steps  remaining steps, from the first one of the slice on
/// @param slices remaining slices, including this one, >= 1
/// @param ratio  counted so far, >= 1; infinity: unknown
/// @return       number of steps, not rounded
double adaptive_cut(std::int64_t steps, int slices, double ratio);

/// Progress of a slice.
struct SliceDone {
  std::int64_t steps = 0;
  double work = 0;  ///< of these steps and of the recovery

  /// The progress that a slice had made when its work reached `most`.
  /// @param work [steps done + 1, at least 1] total after its recovery, then after each step
  static SliceDone within(const std::vector<double>& work, double most);
};

/// Algorithm 1, with counted work in place of time. Decides where slices begin, while the coarse
/// run and the slices behind it are running. The decisions depend on counted work alone, not on the
/// speed of workers: the progress of a slice is measured when its work equals that of the coarse
/// run since the start of the slice.
///
/// The ratio of eq. (7) comes from the latest slices that have done known_steps together. As long
/// as all slices have done fewer, the ratio counts as unknown, and slices get equal lengths. The
/// paper uses the current slice alone, from its first step on. If the ratio exceeds the number of
/// steps per slice, these are one or two steps, perhaps from a time when the cloth hardly moves.
/// They can make a slice so long that the other slices cannot make up for it.
///
/// For the same reason, no slice is longer than length_max times an equal share of the remaining
/// steps. A ratio that is low for a while then does not decide the whole schedule.
class AdaptiveCuts {
 public:
  /// Number of steps that suffice to estimate the ratio.
  static constexpr std::int64_t known_steps = 20;
  /// Maximum length of a slice over an equal share of the remaining steps.
  static constexpr double length_max = 1.3;

  /// @pre 1 <= slices <= steps
  AdaptiveCuts(std::int64_t steps, int slices);

  /// First steps of the slices decided so far; the first is 0.
  const std::vector<std::int64_t>& starts() const { return starts_; }
  bool complete() const { return static_cast<int>(starts_.size()) == slices_; }

  /// Number of the slice whose end is decided next.
  int slice() const { return static_cast<int>(starts_.size()) - 1; }

  /// Reports progress of the coarse run.
  /// @param step  first fine step that it has not reached; larger than in the last call
  /// @param work  counted since the start of the coarse run
  /// @pre the end of slice() could not be decided before
  void advance_coarse(std::int64_t step, double work);

  /// Uses the progress that slices had made some work ago, so that the slices need not wait for
  /// each other. Before this is set, no progress counts.
  /// @param work how long ago, in counted work, >= 0
  void set_delay(double work) { delay_ = work; }
  bool has_delay() const { return delay_ < std::numeric_limits<double>::infinity(); }

  /// The work of the coarse run since the start of a slice, less the delay. Before decide() is
  /// called, the slice must have done this work, or have reached the last step that it may do.
  double work_wanted(int slice) const;

  /// Decides whether slice() ends at a step that the coarse run has reached. It never ends before
  /// the step that the coarse run had reached one advance_coarse() earlier.
  /// @param done returns the progress of slice() or an earlier slice within its work_wanted()
  /// @return     true: slice() ends there, and starts() has one more entry
  bool decide(const std::function<SliceDone(int slice, double work_wanted)>& done);

 private:
  double coarse_work(std::int64_t step) const;
  double ratio(const std::function<SliceDone(int slice, double work_wanted)>& done) const;

  std::int64_t steps_;
  int slices_;
  std::vector<std::int64_t> starts_{0};
  std::vector<std::int64_t> coarse_steps_{0};
  std::vector<double> coarse_work_{0};
  double delay_ = std::numeric_limits<double>::infinity();
};

/// Known costs of all steps, from which a schedule can be evaluated.
struct ScheduleCosts {
  std::vector<double> coarse;  ///< [steps + 1] of the coarse run until it reaches each step
  std::vector<double> fine;    ///< [steps + 1] of the fine run until it reaches each step
  double recovery = 0;         ///< of each slice but the first
};

/// Time at which the last of the slices ends, if each begins when the coarse run reaches its start.
/// Each slice has its own worker; the last one uses that of the coarse run.
/// @param starts first steps of slices, increasing from 0
double schedule_length(const ScheduleCosts& costs, const std::vector<std::int64_t>& starts);

/// First steps of slices by algorithm 1, for known costs.
std::vector<std::int64_t> adaptive_starts(const ScheduleCosts& costs, int slices);

}  // namespace weft
