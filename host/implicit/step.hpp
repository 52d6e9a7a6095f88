#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "host/implicit/attempt.hpp"
#include "host/implicit/collision_resolver.hpp"
#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/contact_motion_limit.hpp"
#include "host/implicit/external_work.hpp"
#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/stage_clock.hpp"
#include "host/implicit/prescribed_motion.hpp"
#include "host/implicit/row_sharing.hpp"
#include "host/implicit/state_update.hpp"
#include "host/implicit/step_failure.hpp"
#include "host/implicit/step_publisher.hpp"
#include "host/implicit/step_solver.hpp"
#include "host/implicit/tracking/tracking.hpp"
#include "host/implicit/truncated_step.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/step_method.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// The implicit method (P-Cloth sections 2.5 to 4) over the ranks of a device set.
template <class T>
class ImplicitStep final : public StepMethod {
 public:
  /// @param before step of the previous topology, for its detection hints; null: none
  explicit ImplicitStep(Store<T>& store, const ImplicitStep* before = nullptr);

  /// Advances the store by `dt`, on the first fallback level of ARCHITECTURE.md that succeeds. If
  /// none does, or if the devices are told to stop, report.failure says why, and the store is
  /// unchanged.
  void advance(double dt, StepReport& report) override;

  /// Called with every accepted step or substep, before its end becomes the state. A substep may
  /// still be undone if a later one fails. positions_t0, positions_t1: [vertices] [m] on rank 0 of
  /// the host
  using Watch = typename TruncatedStep<T>::Watch;
  /// Sets the callback for later steps; null: none.
  void watch(Watch watch) { watch_ = std::move(watch); }

  void publish_on(ProgressBoard& board) override { publisher_.publish_on(board); }
  ProgressBoard& board() const { return publisher_.board(); }

  /// Continuous detection of a motion that is not a step: the collisions of the cloth if some of
  /// its vertices move straight to new positions and everything else stays in place.
  /// @param moves  cloth vertices
  /// @param report counts the search and the tests
  std::vector<Collision> collisions_on_the_way(const std::vector<MovedVertex<T>>& moves,
                                               StepReport& report) {
    return resolver_.collisions_on_the_way(moves, report);
  }

  /// Times the stages of later steps one by one: a stage begins only when all ranks have finished
  /// the previous one, so its time is that of the slowest rank. For benchmarks; off by default.
  void time_apart(bool apart) { clock_.wait_for_all(apart); }

  /// Searches pairs in every later step, even if those of an earlier step are still valid. Results
  /// do not depend on it. For benchmarks; off by default.
  void search_every_step(bool every_step) { search_every_step_ = every_step; }

  /// Makes later steps track these targets; null: none.
  /// @throws DeviceError unless there is a single rank, on the host
  void track(std::shared_ptr<const Tracking> tracking);

  /// Redistributes the rows among ranks, between two steps. Results do not depend on it.
  /// @param row_begin as in Partition
  void share_rows(std::vector<Index> row_begin) { rows_.share(std::move(row_begin)); }

  /// Moves the cloth straight to other positions, and obstacles and pinned vertices to their
  /// positions at `time`, which becomes the time of the state. This is a motion, not a step: impact
  /// zones resolve collisions on the way; velocities and the contact cache do not change.
  /// @param places [cloth vertices] [m]
  /// @return       whether it succeeded; if not, the state is unchanged and the report says why
  bool displace(const std::vector<Vec3<T>>& places, double time, StepReport& report);

 private:
  // The levels of fallback: whole, halved and rigid; truncated.
  std::optional<Fallback> advance_bisecting(double dt, int bisections_left, StepReport& report);
  bool advance_truncating(double dt, int bisections_left, bool attempted, StepReport& report);
  // An attempt and its stages.
  bool attempt(const Attempt& a, StepReport& report);
  Attempt make_attempt(double dt, bool must_stand, bool whole = false) const;
  void set_base(const Attempt& a);
  void predict(const Attempt& a);
  Hardening hardening(const Attempt& a) const;
  void add_work(const Attempt& a, const StepReport& report);

  void report_tracking(StepReport& report);

  /// Of all steps so far.
  struct Tally {
    double certificate_seconds;
    std::int64_t allocations, synchronisations;
  };
  Tally tally() const;

  Store<T>& store_;
  std::vector<RankGeometry<T>> geometry_;
  std::vector<RankMotion<T>> motion_;
  StageClock clock_;
  StepPublisher publisher_;
  ContactDetection<T> detection_;
  LinearSystem<T> system_;
  RowSharing<T> rows_;
  StepSolver<T> solver_;
  PrescribedMotion<T> prescribed_;
  ContactMotionLimit<T> motion_limit_;
  CollisionResolver<T> resolver_;
  StateUpdate<T> update_;
  TruncatedStep<T> truncated_;
  ExternalWork<T> external_work_;
  std::shared_ptr<const Tracking> tracking_;
  std::unique_ptr<TrackedSystem> tracked_;  ///< null: no tracking
  Watch watch_;
  std::uint64_t epoch_;
  double work_ = 0;  ///< [J] in accepted parts of the step
  bool search_every_step_ = false;
  bool kept_ = false;       ///< the store has saved the start of the step
  double step_begin_ = 0;   ///< [s] of the step that is under way
  double step_length_ = 0;  ///< [s]
};

}  // namespace weft
