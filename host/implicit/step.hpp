#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "host/implicit/collision_response/impact_zones.hpp"
#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/row_balance.hpp"
#include "host/implicit/stage_clock.hpp"
#include "host/implicit/tracking/tracking.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// The implicit method (P-Cloth sections 2.5 to 4) over the ranks of a device set.
template <class T>
class ImplicitStep {
 public:
  /// @param before of the topology whose place the store's takes; null: none
  explicit ImplicitStep(Store<T>& store, const ImplicitStep* before = nullptr);

  /// Advances the store by `dt`. An attempt that fails is redone in two halves, as often as the
  /// scene allows, and where solves keep failing steps begin with halves, see Backoff; at the
  /// floor impact zones may move rigidly. If that fails too, or the devices are told to stop,
  /// report.failure says why and the store is as it was.
  void advance(double dt, StepReport& report);

  /// Called with every part of a step that stands, before its end becomes the state.
  /// positions_t0, positions_t1: [vertices] [m] on rank 0 of the host
  using Watch =
      std::function<void(Span<const Vec3<T>> positions_t0, Span<const Vec3<T>> positions_t1)>;
  /// Who looks on from now on; null: nobody.
  void watch(Watch watch) { watch_ = std::move(watch); }

  /// Continuous detection of a motion that is no step: what the cloth runs into if some of its
  /// vertices go straight from where they are to other places and all else stays.
  /// @param moves cloth vertices
  std::vector<Collision> collisions_on_the_way(const std::vector<MovedVertex<T>>& moves);

  /// Times the stages of steps from now on one by one: none begins before all ranks are through
  /// with the one before, so that each takes what the slowest rank does. For benchmarks; off at
  /// first.
  void time_apart(bool apart) { clock_.wait_for_all(apart); }

  /// Searches pairs anew in every step from now on, where those of an earlier one hold too. What is
  /// simulated does not depend on it. For benchmarks; off at first.
  void search_anew(bool anew) { search_anew_ = anew; }

  /// Ties steps from now on to a target; null: none.
  /// @throws DeviceError unless all is on one rank of the host
  void track(std::shared_ptr<const Tracking> tracking);

  /// Gives the ranks other rows between two steps. What is simulated does not depend on it.
  /// @param row_begin as in Partition
  void share_rows(std::vector<Index> row_begin);

  /// Moves the state's cloth straight to other places, and obstacles and pinned vertices to where
  /// they are at `time`, which becomes the state's: a motion, not a step. Impact zones part what
  /// would meet on the way. Velocities, and what contacts leave to the next step, stay.
  /// @param places [cloth vertices] [m]
  /// @return       whether it could be done; if not, the state is as it was and the report says why
  bool displace(const std::vector<Vec3<T>>& places, double time, StepReport& report);

 private:
  struct Attempt {
    double dt;
    double h;            ///< [s] effective step of the integrator
    bool at_rest;        ///< x~ is x_n: no element has a rate at the first iterate
    bool last_resort;    ///< the floor of the bisections
    bool solved = true;  ///< its end comes from a system, which may be solved again
  };

  /// What is not where it should be at the end of the attempt because cloth is in between.
  struct ObstacleCompliance {
    int count = 0;        ///< vertices
    double distance = 0;  ///< [m] at most
    double farther = 0;   ///< [m] than at the start, at most
  };

  bool advance_bisecting(double dt, int bisections_left, StepReport& report);
  bool attempt(const Attempt& a, StepReport& report);
  Attempt begin(double dt, bool last_resort);
  void prescribe(double time);
  void set_springs(double time);
  void set_base(const Attempt& a);
  void predict(const Attempt& a);
  bool solve(const Attempt& a, StepReport& report);
  bool solve_once(const Attempt& a, StepReport& report);
  bool solve_newton(const Attempt& a, StepReport& report);
  bool search_line(const Attempt& a, StepReport& report);
  bool solve_again(const Attempt& a, StepReport& report);
  bool iterate_active_set(const Attempt& a, StepReport& report);
  double contact_mismatch(bool last);
  bool finish_solve(const Attempt& a, const SolveFloor& floor, StepReport& report);
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
  bool respond(const Attempt& a, std::size_t first_new, StepReport& report);
  void apply_zones(const Attempt& a);
  ObstacleCompliance measure_compliance();
  void cache_contacts();
  void accept(const Attempt& a);
  void report_tracking(StepReport& report);
  void rebalance(StepReport& report);
  void count_rows(int iterations, StepReport& report);
  bool stopped(StepReport& report);
  bool fail(StepReport& report, Failure failure, const std::string& detail);

  Store<T>& store_;
  std::vector<RankGeometry<T>> geometry_;
  std::vector<RankMotion<T>> motion_;
  ContactDetection<T> search_;
  LinearSystem<T> system_;
  RowBalance row_balance_;
  std::shared_ptr<const Tracking> tracking_;
  std::unique_ptr<TrackedSystem> tracked_;  ///< null: no tracking
  std::vector<unsigned char> fixed_;        ///< as uploaded
  std::vector<MovedVertex<T>> targets_;     ///< of pinned vertices
  std::vector<Buffer<MovedVertex<T>>> rank_targets_, rank_moved_;
  std::vector<Vec3<double>> placed_;  ///< obstacle positions
  std::vector<Vec3<T>> placed_rounded_;
  std::vector<Collision> collisions_;  ///< of all rounds of the attempt
  ImpactZones<T> zones_;
  ZoneMotion zone_motion_ = ZoneMotion::impacts;  ///< in the rest of the attempt
  std::vector<Buffer<double>> rank_mismatch_;
  int unsolved_rounds_ = 0;  ///< in a row
  std::uint64_t epoch_;
  Watch watch_;
  Linearisation at_{};          ///< of the assembled system
  SolveFloor floor_;            ///< what the attempt's last solve was checked against
  double first_reference_ = 0;  ///< [N s] likewise, in its first iteration of Newton's method
  StageClock clock_;
  bool search_anew_ = false;
  bool kept_ = false;  ///< the store has kept the start of the step
};

}  // namespace weft
