#pragma once

#include <cstdint>
#include <vector>

#include "host/implicit/attempt.hpp"
#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/contact_mismatch.hpp"
#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/stage_clock.hpp"
#include "host/implicit/step_publisher.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// Solves the equations of an attempt: with a single linear solve, and with Newton's method where
/// that is not good enough.
template <class T>
class StepSolver {
 public:
  StepSolver(Store<T>& store, const std::vector<RankGeometry<T>>& geometry,
             std::vector<RankMotion<T>>& motion, ContactDetection<T>& detection,
             LinearSystem<T>& system, StageClock& clock, const StepPublisher& publisher);

  /// The springs of handles and seams as they are at `time`, where a step of this length ends.
  void set_springs(double time, double step);
  /// Whether there are springs between vertices.
  bool seams_pull() const noexcept { return seams_pull_; }
  /// Whether the step has fallen back to truncation: cloth is jammed.
  void set_truncating(bool truncating) { truncating_ = truncating; }

  /// Solves, and writes the result to positions_t1 and velocities_t1 of all ranks.
  bool solve(const Attempt& a, StepReport& report);

  /// Solves the last system once more, with the contacts of the latest update_contacts(): those
  /// that the prediction missed, and without those that would pull. An active-set step. After
  /// Newton's method it is another iteration of that, searched along like the others: stiff cloth
  /// is thrown far out of its way by a whole one.
  bool solve_again(const Attempt& a, StepReport& report);

  /// A single linear solve about the positions of the state, with the velocities that lead there
  /// from the start of the step.
  bool solve_about_state(const Attempt& a, StepReport& report);

  /// [cloth vertices] [m] Where elements are linearised in the latest solve, if that was a single
  /// linear one about the state; else empty. In the memory of rank 0.
  Span<const Vec3<T>> linear_about() {
    return at_.moved ? system_.moving_frame(0).positions.span() : Span<const Vec3<T>>{};
  }
  /// Residual of Newton's method after the latest solve. [N s] 2-norm
  double residual(const StepReport& report) const {
    return at_.moved ? 0 : report.newton_residual * first_reference_;
  }

 private:
  /// How contacts are taken after a solve, see AssembleActiveSetUpdate.
  struct ActiveSet {
    bool early = false;
    bool compare = false;
    bool may_become_firm = false;
    bool last = false;
    bool parted = false;
  };

  bool solve_once(const Attempt& a, StepReport& report);
  bool solve_about_start(const Attempt& a, StepReport& report, bool turn);
  bool turned_in_vain();
  bool solve_newton(const Attempt& a, StepReport& report);
  bool refine(const Attempt& a, StepReport& report);
  bool is_nearly_linear(const Attempt& a);
  bool keeps_limits();
  bool search_line(const Attempt& a, StepReport& report);
  bool solve_with_early_look(const Attempt& a, SolveRules rules, StepReport& report);
  bool iterate_active_set(const Attempt& a, StepReport& report);
  bool is_right(const ContactMismatch& mismatch) const;
  ContactMismatch update_active_set(const ActiveSet& how);
  bool finish_solve(const Attempt& a, const SolveRules& rules, StepReport& report,
                    bool may_fall_short = false);
  void assemble();
  void book_assembly(StepReport& report);
  void start_at_state(const Attempt& a, bool turn);
  void start_at_prediction(const Attempt& a);
  void take_iterate();
  void spread_solution(const Attempt& a);

  Store<T>& store_;
  const std::vector<RankGeometry<T>>& geometry_;
  std::vector<RankMotion<T>>& motion_;
  ContactDetection<T>& detection_;
  LinearSystem<T>& system_;
  StageClock& clock_;
  const StepPublisher& publisher_;
  std::vector<Buffer<double>> rank_mismatch_, rank_mismatch_of_contact_;
  std::vector<Buffer<std::int64_t>> rank_force_;  ///< see AssembleActiveSetUpdate
  Linearisation at_{};                            ///< of the assembled system
  SolveRules rules_;                              ///< of the attempt's last solve
  bool seams_pull_ = false;
  bool truncating_ = false;
  bool paused_ = false;            ///< the latest solve has
  std::int32_t resumed_from_ = 0;  ///< iterations of the latest solve so far
  bool refined_ = false;           ///< the attempt has turned to Newton's method
  double first_reference_ = 0;     ///< [N s] reference of the first iteration of Newton's method
};

}  // namespace weft
