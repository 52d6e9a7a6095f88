#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "host/implicit/collision_response/impact_zones.hpp"
#include "host/implicit/collision_response/truncated_motion.hpp"
#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/contact_mismatch.hpp"
#include "host/implicit/external_work.hpp"
#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/row_balance.hpp"
#include "host/implicit/progress_board.hpp"
#include "host/implicit/stage_clock.hpp"
#include "host/implicit/step_error.hpp"
#include "host/implicit/tracking/tracking.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// The implicit method (P-Cloth sections 2.5 to 4) over the ranks of a device set.
template <class T>
class ImplicitStep {
 public:
  /// @param before step of the previous topology, for its detection hints; null: none
  explicit ImplicitStep(Store<T>& store, const ImplicitStep* before = nullptr);

  /// Advances the store by `dt`. An attempt that fails is repeated as two halves, as often as the
  /// scene allows. If solves keep failing, steps begin bisected, see Backoff. In the shortest
  /// substep impact zones may move as rigid bodies. If that fails too, or takes too much work,
  /// motions are truncated. If prescribed vertices would then miss their targets by more than they
  /// may, or if the devices are told to stop, report.failure says why, and the store is unchanged.
  void advance(double dt, StepReport& report);

  /// Called with every accepted step or substep, before its end becomes the state.
  /// positions_t0, positions_t1: [vertices] [m] on rank 0 of the host
  using Watch =
      std::function<void(Span<const Vec3<T>> positions_t0, Span<const Vec3<T>> positions_t1)>;
  /// Sets the callback for later steps; null: none.
  void watch(Watch watch) { watch_ = std::move(watch); }

  /// Publishes the progress of later steps on this board. Results do not depend on it.
  /// @param board must outlive the steps; its owner begins and ends each step on it
  void publish_on(ProgressBoard& board) { board_ = &board; }
  ProgressBoard& board() const { return *board_; }

  /// Continuous detection of a motion that is not a step: the collisions of the cloth if some of
  /// its vertices move straight to new positions and everything else stays in place.
  /// @param moves cloth vertices
  std::vector<Collision> collisions_on_the_way(const std::vector<MovedVertex<T>>& moves);

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
  void share_rows(std::vector<Index> row_begin);

  /// Moves the cloth straight to other positions, and obstacles and pinned vertices to their
  /// positions at `time`, which becomes the time of the state. This is a motion, not a step: impact
  /// zones resolve collisions on the way; velocities and the contact cache do not change.
  /// @param places [cloth vertices] [m]
  /// @return       whether it succeeded; if not, the state is unchanged and the report says why
  bool displace(const std::vector<Vec3<T>>& places, double time, StepReport& report);

 private:
  struct Attempt {
    double dt;
    double h;            ///< [s] effective step of the integrator
    bool at_rest;        ///< x~ is x_n, so strain rates are 0 at the first iterate
    bool last_resort;    ///< the shortest substep: zones may move as rigid bodies
    bool solved = true;  ///< its end is the solution of a system that may be solved again
  };

  /// Prescribed vertices that end the attempt short of their targets because cloth is in between.
  struct ObstacleCompliance {
    int count = 0;
    double distance = 0;        ///< [m] at most
    double farther = 0;         ///< [m] than at the start, at most
    double over_limit = 0;      ///< distance over what is allowed, at most
    std::vector<Index> over;    ///< vertices that exceed what is allowed
    Index worst = -1;           ///< vertex of over_limit
    double worst_distance = 0;  ///< [m] its distance
  };

  /// The start of a truncated step.
  struct Start {
    struct Rank {
      Buffer<Vec3<T>> positions;
      Buffer<ContactMemory<T>> contacts;
    };
    std::vector<Rank> ranks;
    std::int64_t face_contacts = 0;
  };

  bool advance_bisecting(double dt, int bisections_left, StepReport& report);
  bool advance_truncating(double dt, int bisections_left, bool attempted, StepReport& report);
  bool attempt(const Attempt& a, StepReport& report);
  bool truncate(const Attempt& a, bool may_bisect, StepReport& report);
  void keep_start();
  bool approach(const Attempt& a, int pass, StepReport& report);
  bool resolve_again(const Attempt& a, StepReport& report);
  bool clear_path(const Attempt& a, TruncationKind kind, bool& complete, StepReport& report);
  double farthest_prescribed();
  void grant_approaches();
  bool may_approach() const { return approaches_left_ > 0 && truncated_collisions_left_ > 0; }
  void take_part_way();
  void return_to_start(const Attempt& a, bool good);
  Attempt begin(double dt, bool last_resort);
  void prescribe(double time);
  void set_springs(double time);
  void measure_turning(const Attempt& a);
  bool contacts_move_too_far(double dt) const;
  void set_base(const Attempt& a);
  void predict(const Attempt& a);
  bool solve(const Attempt& a, StepReport& report);
  bool solve_once(const Attempt& a, StepReport& report);
  bool solve_newton(const Attempt& a, StepReport& report);
  bool refine(const Attempt& a, StepReport& report);
  bool is_nearly_linear(const Attempt& a);
  bool keeps_limits();
  bool search_line(const Attempt& a, StepReport& report);
  bool solve_again(const Attempt& a, StepReport& report);
  bool iterate_active_set(const Attempt& a, StepReport& report);
  ContactMismatch contact_mismatch(bool last);
  bool finish_solve(const Attempt& a, const SolveFloor& floor, StepReport& report,
                    bool may_fall_short = false);
  void assemble();
  void book_assembly(StepReport& report);
  void start_at_state(const Attempt& a);
  void start_at_prediction(const Attempt& a);
  void take_iterate();
  void spread_solution(const Attempt& a);
  bool resolve_collisions(const Attempt& a, StepReport& report);
  void begin_rounds();
  bool certified(const Attempt& a, StepReport& report);
  bool zones_gain_energy(double dt);
  bool zones_stretch(const Attempt& a);
  bool zones_break_limits(const Attempt& a);
  bool respond(const Attempt& a, std::size_t first_new, StepReport& report);
  void apply_moved(const std::vector<MovedVertex<T>>& moved, const Attempt& a);
  double compliance_limit(Index v) const;
  ObstacleCompliance measure_compliance();
  bool fail_compliance(const ObstacleCompliance& c, double dt, StepReport& report);
  std::int64_t zone_budget() const;
  void grant_zone_visits(std::int64_t visits);
  void publish_zone_work();
  void enter(StepStage stage, const StepReport& report);
  void publish_substep(const Attempt& a);
  /// Attempts that will probably fail, and the solves of a truncated step, get only one part in so
  /// many of a step's work on impact zones.
  static constexpr std::int64_t zone_share = 8;
  /// Other attempts that may be bisected get one part in so many of what is left.
  static constexpr std::int64_t attempt_share = 4;
  /// Solves that truncated parts of a step may take.
  static constexpr int approaches_of_step_max = 128;
  void cache_contacts(const Attempt& a);
  bool hardens() const;
  void remember_touched(bool raise);
  void accept(const Attempt& a);
  void add_work(const Attempt& a, const StepReport& report);
  void report_tracking(StepReport& report);
  void rebalance(StepReport& report);
  void count_rows(int iterations, StepReport& report);
  bool stopped(StepReport& report);
  /// Notes why the attempt has failed.
  /// @param place [m] see StepReport::failure_place
  /// @return      false
  bool fail(StepReport& report, Failure failure, const std::string& detail,
            const std::optional<Vec3<double>>& place = {});
  std::optional<Vec3<double>> place_of(const Collision& collision);
  std::optional<Vec3<double>> place_not_finite();
  std::optional<Vec3<double>> pinched_place(std::size_t first_new);
  /// Whether the latest attempt failed because its collisions could not be resolved.
  static bool collisions_failed(const StepReport& report) {
    return report.failure == Failure::intersection || report.failure == Failure::pinched;
  }

  Store<T>& store_;
  std::vector<RankGeometry<T>> geometry_;
  std::vector<RankMotion<T>> motion_;
  ContactDetection<T> search_;
  LinearSystem<T> system_;
  RowBalance row_balance_;
  std::shared_ptr<const Tracking> tracking_;
  std::unique_ptr<TrackedSystem> tracked_;  ///< null: no tracking
  std::vector<unsigned char> fixed_;        ///< [vertices] as uploaded, see fixed_vertices()
  std::vector<MovedVertex<T>> targets_;     ///< of pinned vertices
  std::vector<Buffer<MovedVertex<T>>> rank_targets_, rank_moved_;
  std::vector<Vec3<double>> placed_;  ///< obstacle positions
  std::vector<Vec3<T>> placed_rounded_;
  std::vector<Vec3<double>> placed_before_;  ///< at the start of the attempt, if any rotates
  /// [m/s^2] at which rotating obstacles leave the planes of contacts, at most, in this step
  double turning_acceleration_ = 0;
  double slide_speed_ = 0;             ///< [edges/s] see ContactDetection::slide()
  std::vector<Collision> collisions_;  ///< of all rounds of the attempt
  ImpactZones<T> zones_;
  ZoneMotion zone_motion_ = ZoneMotion::impacts;  ///< for the remaining rounds of the attempt
  std::vector<Buffer<double>> rank_mismatch_;
  std::vector<Buffer<std::int64_t>> rank_friction_;  ///< see AssembleActiveSetUpdate
  TruncatedMotion<T> truncated_;
  ExternalWork<T> external_work_;
  double work_ = 0;  ///< [J] in accepted parts of the step
  Start start_;
  bool stretched_ = false;        ///< by zones in a shortest part of the step, see zones_stretch()
  std::int64_t visits_left_ = 0;  ///< of collisions by impact zones, in this step
  std::int64_t visits_reserved_ = 0;            ///< for the halves of the attempt, if it fails
  std::int64_t visits_granted_ = 0;             ///< what visits_left_ began with
  int approaches_left_ = 0;                     ///< solves of truncated steps, in this step
  std::int64_t truncated_collisions_left_ = 0;  ///< of truncated motions, in this step
  int unsolved_rounds_ = 0;                     ///< in a row
  std::uint64_t epoch_;
  Watch watch_;
  Linearisation at_{};          ///< of the assembled system
  SolveFloor floor_;            ///< of the attempt's last solve
  bool seams_pull_ = false;     ///< springs between vertices are in the system
  bool refined_ = false;        ///< the attempt has turned to Newton's method
  double first_reference_ = 0;  ///< [N s] reference of the first iteration of Newton's method
  StepError<T> error_estimate_;
  double step_error_ = 0;  ///< of the accepted parts of the step; 0 with fixed steps
  StageClock clock_;
  bool search_every_step_ = false;
  bool kept_ = false;        ///< the store has saved the start of the step
  ProgressBoard own_board_;  ///< if nobody has asked for the progress
  ProgressBoard* board_ = &own_board_;
  double step_begin_ = 0;    ///< [s] of the step that is under way
  double step_length_ = 0;   ///< [s]
  double nominal_step_;      ///< [s] the scene's step, or the length of an automatic one
  bool truncating_ = false;  ///< the step has fallen back to truncation
};

}  // namespace weft
